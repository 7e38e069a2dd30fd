"""Provenance of results: code, versions, data and machine, for manifests and stamps."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
import subprocess
from importlib import metadata
from pathlib import Path

from hazbot_gym.utils import processors

PACKAGE = Path(__file__).parent.parent
_DEPENDENCIES = (
    "gymnasium",
    "numba",
    "numpy",
    "optuna",
    "pandas",
    "pyarrow",
    "pydantic",
    "pymunk",
    "sb3-contrib",
    "scikit-fuzzy",
    "scipy",
    "stable-baselines3",
    "torch",
)


def versions() -> dict[str, str]:
    """Return the versions of Python, hazbot_gym and its dependencies, as far as installed."""
    found = {"python": platform.python_version(), "hazbot-gym": _version("hazbot-gym")}
    found |= {name: _version(name) for name in _DEPENDENCIES}
    return {name: version for name, version in found.items() if version}


def commit() -> str | None:
    """Return the git commit of the checkout, ``-dirty`` if it was edited; None for an install."""
    if not (PACKAGE.parent / ".git").exists():
        return None
    try:
        name = _git("describe", "--always", "--abbrev=40")
        return f"{name}-dirty" if _git("status", "--porcelain", "--untracked-files=no") else name
    except (OSError, subprocess.CalledProcessError):
        return None


def stamp(data: Path | None = None) -> str:
    """Return a hash of the code, the versions and the data files that numbers depend on."""
    parts = {"code": _code(PACKAGE), "versions": versions()}
    if data is not None:
        parts["data"] = digest(data)
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def digest(root: Path, pattern: str = "*") -> str:
    """Return a hash of the names and contents of all files under a folder, or of one file."""
    total = hashlib.sha256()
    files = [root] if root.is_file() else sorted(p for p in root.rglob(pattern) if p.is_file())
    for path in files:
        total.update(path.relative_to(root).as_posix().encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


def machine() -> dict[str, str | int]:
    """Return the machine: processor, number of cores, system, Python, numba."""
    return {
        "processor": _processor(),
        "cores": processors.usable(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numba": _version("numba"),
    }


def _git(*arguments: str) -> str:
    """Return git's output about the checkout; strictly read-only, index included."""
    command = ["git", "--no-optional-locks", "-C", str(PACKAGE.parent), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


@functools.cache
def _code(package: Path) -> str:
    """Return the digest of the source files, read once, as the process runs the loaded code."""
    return digest(package, "*.py")


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"

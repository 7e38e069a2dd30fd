"""Digests of all input files that results depend on.

For an environment these are the files of its place or its recordings, and a ``config`` file. For a
policy of the library it is its weights file. A user's own policy is built and queried once in a
separate process, which records every imported module outside the installed packages and every file
that Python opens for reading.
"""

from __future__ import annotations

import hashlib
import os
import site
import sys
import sysconfig
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.evaluation.workers import processes
from hazbot_gym.policies.base import NO_CODE, REGISTER, Permissions
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.policies.learned import Learned
from hazbot_gym.policies.shielded import Shielded
from hazbot_gym.task.inputs import input_files
from hazbot_gym.task.observation import Layout, observing_layout
from hazbot_gym.utils import provenance

COMPILED = (".pyc", ".nbi", ".nbc")  # caches of Python and numba
SYSTEM = (Path("/dev"), Path("/proc"), Path("/sys"))


class Blank(NamedTuple):
    """Observations of zeros."""

    layout: Layout
    rows: tuple[int, ...] = ()  # number of observations, if stacked


def of_set(scenarios: ScenarioSet) -> list[Path]:
    """Return the input files of a set's environment.

    Raises:
        InvalidInput: There is no such environment, or one of the files cannot be used.
    """
    config, _ = resolve(scenarios)
    given = scenarios.overrides.get("config")
    return [*([Path(given)] if isinstance(given, str | Path) else []), *input_files(config)]


def of_policy(spec: str, blanks: Iterable[Blank], allowed: Permissions = NO_CODE) -> list[Path]:
    """Return the input files of a policy.

    Args:
        spec: Argument of ``policies.base.make``.
        blanks: Observations to query it with.
        allowed: Permissions of the policy, such as unpickling.
    """
    if spec.partition(":")[0] in REGISTER:
        policy = make_policy(spec, **allowed._asdict())
        if isinstance(policy, Shielded):
            return of_policy(policy.policy, blanks, allowed)
        if not isinstance(policy, Learned):
            return []
        if policy.path.suffix != ".zip":  # whose pickles import modules
            return [policy.path]
    with processes(1) as pool:  # a fresh process, with nothing imported yet
        return [Path(name) for name in pool.submit(_noted, (spec, allowed, *blanks)).result()]


def digests(paths: Iterable[Path]) -> dict[str, str]:
    """Return the SHA-256 of each file's content, by its path."""
    return {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def edited(before: Mapping[str, str]) -> str | None:
    """Return the first file whose content is no longer that of its ``digests``; else None."""
    for name, digest in before.items():
        path = Path(name)
        if not path.is_file() or digests([path])[name] != digest:
            return name
    return None


def changed(before: Mapping[str, str], now: Mapping[str, str]) -> str | None:
    """Return the first file that was edited, added or removed, of two ``digests``; else None.

    Moving their common parent folder does not count as a change.
    """
    new, old = _within(now), _within(before)
    for each, other in ((new, old), (old, new)):
        for (name, digest), path in each.items():
            if (name, digest) not in other:
                return path
    return None


def mark(paths: Iterable[Path]) -> str:
    """Return a hash of files' names and contents, independent of their common parent folder."""
    found = sorted(_within(digests(paths)))
    return hashlib.sha256(repr(found).encode()).hexdigest()[:16]


def last_change(path: Path) -> tuple[int, int]:
    """Return size and modification time of a file, a fast check for edits."""
    about = path.stat()
    return about.st_size, about.st_mtime_ns


def _within(found: Mapping[str, str]) -> dict[tuple[str, str], str]:
    """Return paths relative to their common parent folder, and by digest."""
    absolute = {os.path.abspath(path): path for path in found}
    top = os.path.commonpath([os.path.dirname(path) for path in absolute]) if absolute else ""
    return {
        (Path(os.path.relpath(full, top)).as_posix(), found[path]): path
        for full, path in absolute.items()
    }


def _noted(task: tuple[Any, ...]) -> list[str]:
    """Build and query a policy; return the files that it used outside the installed packages."""
    spec, allowed, *blanks = task
    opened: set[str] = set()

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and not isinstance(arguments[0], int):
            name, _, flags = arguments
            if not flags & (os.O_WRONLY | os.O_CREAT | os.O_TRUNC):  # "r+", too, may only read
                opened.add(os.path.abspath(os.fsdecode(name)))
        elif event == "sqlite3.connect":
            opened.add(os.path.abspath(os.fsdecode(arguments[0])))

    sys.addaudithook(note)  # for good: the process ends after this
    policy = make_policy(spec, **allowed._asdict())
    for layout, rows in blanks:
        starts, blank = np.ones(rows or 1, np.bool_), np.zeros((*rows, layout.width), np.float32)
        with observing_layout(layout):
            policy.predict(blank, episode_start=starts, deterministic=True)
    modules = [getattr(module, "__file__", None) for module in list(sys.modules.values())]
    opened.update(os.path.abspath(file) for file in modules if file)
    return sorted(name for name in opened if _is_own(Path(name)))


def _is_own(path: Path) -> bool:
    """Return True if a file belongs neither to the system nor to an installed package."""
    if path.suffix in COMPILED or not path.is_file():
        return False
    paths = sysconfig.get_paths()
    installed = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    installed += [*site.getsitepackages(), site.getusersitepackages()]
    roots = [provenance.PACKAGE, *SYSTEM, *map(Path, installed)]
    places = (path, path.resolve())
    return not any(each.is_relative_to(root) for each in places for root in (*roots,))

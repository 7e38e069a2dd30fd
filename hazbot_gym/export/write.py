"""Files of an export, written into a folder."""

from __future__ import annotations

import json
from pathlib import Path

from hazbot_gym import __version__
from hazbot_gym.errors import InvalidInput
from hazbot_gym.export.golden import as_json, golden_of
from hazbot_gym.export.plan import Plan, plan_of
from hazbot_gym.utils.files import write_bytes, write_text

FORMATS = ("onnx", "c")
ONNX, GOLDEN = "policy.onnx", "golden.json"


def export(
    policy: str,
    format: str,
    out: Path,
    *,
    tier: str | None = None,
    overwrite: bool = False,
) -> list[Path]:
    """Export a policy; return the files.

    Args:
        policy: Its spec, as of ``make_policy``.
        format: ``onnx`` or ``c``.
        out: The folder, made if it is missing.
        tier: Tier of the observations; default that of a trained policy, ``tracks`` for others.
        overwrite: Whether to replace files that exist.

    Raises:
        InvalidInput: The policy cannot be exported, or a file exists.
        MissingExtra: The format's package is not installed.
    """
    if format not in FORMATS:
        raise InvalidInput(f"format: given {format!r}, allowed are {', '.join(FORMATS)}")
    files = _files(plan_of(policy, tier), format)
    paths = {out / name: content for name, content in files.items()}
    for path in paths:
        if path.exists() and not overwrite:
            raise InvalidInput(f"out: {str(path)!r} exists; give another folder, or --force")
    for path, content in paths.items():
        write = write_bytes if isinstance(content, bytes) else write_text
        write(path, content)  # type: ignore[arg-type]  # of the kind that was just told apart
    return list(paths)


def _files(plan: Plan, format: str) -> dict[str, str | bytes]:
    golden = golden_of(plan)
    vectors = json.dumps(as_json(plan, golden), indent=1, allow_nan=False) + "\n"
    if format == "onnx":
        from hazbot_gym.export.onnx_file import onnx_model

        return {ONNX: onnx_model(plan), GOLDEN: vectors}
    from hazbot_gym.export.c_code import c_files

    return {**c_files(plan, golden, __version__), GOLDEN: vectors}

"""Bundle of everything a worker on another machine needs: input files, and the versions to match.

Input files inside the working folder are copied, and the worker's working folder becomes that copy.
Files elsewhere must have the same path and content on every machine.
"""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.errors import HazbotError, InvalidInput
from hazbot_gym.evaluation.inputs import digests, edited
from hazbot_gym.utils import provenance


class Bundle(NamedTuple):
    """Input files and versions, of the machine where a study was started."""

    folder: str  # the working folder
    versions: dict[str, str]
    stamp: str  # of the package's code, too
    copied: dict[str, bytes]  # content of files, by their path from the working folder
    shared: dict[str, str]  # digests of files elsewhere, by their path


def pack(files: Iterable[Path]) -> Bundle:
    """Return the bundle of some input files."""
    here = Path.cwd()
    paths = dict.fromkeys(Path(os.path.abspath(path)) for path in files)
    inside = [path for path in paths if path.is_relative_to(here)]
    return Bundle(
        str(here),
        provenance.versions(),
        provenance.stamp(),
        {str(path.relative_to(here)): path.read_bytes() for path in inside},
        digests(path for path in paths if path not in inside),
    )


def unpack(bundle: Bundle) -> tempfile.TemporaryDirectory[str] | None:
    """Copy a bundle's files into a new working folder, and return it if there are any.

    Raises:
        HazbotError: This machine has other versions.
        InvalidInput: A file outside the working folder is missing here, or is another one.
    """
    _check_versions(bundle)
    name = edited(bundle.shared)
    if name is not None:
        raise InvalidInput(
            f"cluster: {platform.node()} has no {name!r} with the same content; name files by "
            "paths inside the folder that you start from, which are copied, or put them at the "
            "same path on every machine"
        )
    if not bundle.copied:
        return None
    folder = tempfile.TemporaryDirectory(prefix="hazbot-inputs-")
    for name, content in bundle.copied.items():
        path = Path(folder.name, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    os.chdir(folder.name)
    if bundle.folder != str(provenance.PACKAGE.parent):  # Ray adds it, and its modules are copied
        sys.path[:] = [each for each in sys.path if each != bundle.folder]
    return folder


def _check_versions(bundle: Bundle) -> None:
    """Raise HazbotError unless package and dependencies are the same, since results would not."""
    here = provenance.versions()
    differing = sorted(
        name for name in {*here, *bundle.versions} if here.get(name) != bundle.versions.get(name)
    )
    if differing:
        name = differing[0]
        raise HazbotError(
            f"cluster: {platform.node()} has {name} {here.get(name, 'not')}, the machine of the "
            f"command {bundle.versions.get(name, 'not')}; install the same on both"
        )
    if provenance.stamp() != bundle.stamp:
        raise HazbotError(
            f"cluster: {platform.node()} has other code of hazbot_gym than the machine of the "
            "command; install the same on both"
        )

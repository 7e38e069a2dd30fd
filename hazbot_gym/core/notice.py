"""One line, once, when kernels are compiled: the first use of a version takes its time.

It goes through ``logging``, which prints it on stderr where nobody has set logging up. Kernels that
come from the cache on disk say nothing.
"""

from __future__ import annotations

import logging
from typing import Any

from numba.core import event

_PACKAGE = __name__.partition(".")[0]
MESSAGE = f"{_PACKAGE}: compiling for this processor, once; takes up to a minute ..."


class Notice(event.Listener):
    """Listens to numba's compiler."""

    def __init__(self) -> None:
        self._has_spoken = False

    def on_start(self, compilation: Any) -> None:
        """Speak up at the first function of this package."""
        module = compilation.data["dispatcher"].py_func.__module__
        if module.partition(".")[0] == _PACKAGE and not self._has_spoken:
            self._has_spoken = True
            logging.getLogger(_PACKAGE).warning(MESSAGE)

    def on_end(self, compilation: Any) -> None:
        """Say nothing."""


def install() -> None:
    """Announce the first compilation from now on."""
    event.register("numba:compile", Notice())  # type: ignore[no-untyped-call]

"""One line a process when kernels are compiled: the first use of each takes its time.

It goes through ``logging``, which prints it on stderr where nobody has set logging up. Kernels that
come from the cache on disk say nothing.
"""

from __future__ import annotations

import logging
from typing import Any

from numba.core import event

_PACKAGE = __name__.partition(".")[0]
MESSAGE = f"{_PACKAGE}: compiling kernels that are not in the cache yet; takes up to a minute ..."


class Notice(event.Listener):
    """Listens to numba's compiler.

    Attributes:
        has_spoken: Whether the line has been printed, or is not to be.
    """

    def __init__(self) -> None:
        self.has_spoken = False

    def on_start(self, compilation: Any) -> None:
        """Speak up at the first function of this package."""
        module = compilation.data["dispatcher"].py_func.__module__
        if module.partition(".")[0] == _PACKAGE and not self.has_spoken:
            self.has_spoken = True
            logging.getLogger(_PACKAGE).warning(MESSAGE)

    def on_end(self, compilation: object) -> None:
        """Say nothing."""


NOTICE = Notice()  # of this process; one whose parent has spoken says nothing more


def install() -> None:
    """Announce the first compilation from now on."""
    event.register("numba:compile", NOTICE)  # type: ignore[no-untyped-call]

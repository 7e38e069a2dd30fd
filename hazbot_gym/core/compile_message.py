"""Compile message: one line per process when kernels are compiled, which takes time.

It uses ``logging``, which prints to stderr by default. Kernels from the disk cache cause no
message.
"""

from __future__ import annotations

import logging
from typing import Any

try:
    from numba.core import event
except ImportError:  # nothing is compiled
    event = None  # type: ignore[assignment]

_PACKAGE = __name__.partition(".")[0]
MESSAGE = f"{_PACKAGE}: compiling kernels that are not in the cache yet; takes up to a minute ..."


class CompileMessage(event.Listener if event else object):  # type: ignore[misc]
    """Listener of numba's compiler events.

    Attributes:
        has_spoken: Whether the line was printed, or is suppressed.
    """

    def __init__(self) -> None:
        self.has_spoken = False

    def on_start(self, compilation: Any) -> None:
        """Print the line at the first function of this package."""
        function = compilation.data["dispatcher"].py_func
        module = function.__module__ or ""  # None for code that was made while running
        if module.partition(".")[0] == _PACKAGE and not self.has_spoken:
            self.has_spoken = True
            logging.getLogger(_PACKAGE).warning(MESSAGE)

    def on_end(self, compilation: object) -> None:
        """Do nothing."""


COMPILE_MESSAGE = CompileMessage()  # of this process; silent if the parent printed the line


def install() -> None:
    """Install the listener."""
    event.register("numba:compile", COMPILE_MESSAGE)  # type: ignore[no-untyped-call]  # numba's own

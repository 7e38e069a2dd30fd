"""Interrupts from the keyboard (SIGINT) that take effect at whatever moment they come."""

from __future__ import annotations

import signal
import sys
import threading

AGAIN_AFTER_S = 0.05  # by then the code that cannot be interrupted is usually left


def repeat_ignored_interrupts() -> None:
    """From now on, send an interrupt again that came while Python could not raise it.

    In a finalizer, or in a function that C code calls (numba does both while it loads kernels),
    Python reports a KeyboardInterrupt as "Exception ignored" and goes on.
    """
    usual = sys.unraisablehook

    def hook(ignored: sys.UnraisableHookArgs) -> None:
        if not issubclass(ignored.exc_type, KeyboardInterrupt):
            usual(ignored)
            return
        main = threading.main_thread().ident
        threading.Timer(AGAIN_AFTER_S, signal.pthread_kill, (main, signal.SIGINT)).start()

    sys.unraisablehook = hook

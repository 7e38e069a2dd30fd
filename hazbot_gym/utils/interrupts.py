"""Reliable keyboard interrupts (SIGINT), also inside finalizers and C callbacks."""

from __future__ import annotations

import signal
import sys
import threading

AGAIN_AFTER_S = 0.05  # time to leave code that cannot be interrupted


def repeat_ignored_interrupts() -> None:
    """Resend interrupts that arrive while Python cannot raise them.

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

"""Errors and warnings for users; any other exception is a bug."""

import sys


class HazbotError(Exception):
    """Base class of all errors that hazbot_gym raises on purpose."""


class InvalidInput(HazbotError, ValueError):
    """An input value is not usable.

    The message is one line that names the field, the given value and the allowed values; the
    command line prints it and exits with code 2.
    """


class UnknownKeyword(InvalidInput, TypeError):
    """Unknown constructor argument; also a TypeError, for callers that retry without it."""


class MissingExtra(HazbotError, ImportError):
    """An optional dependency cannot be imported; the message names the ``pip install`` that helps.

    Raised while an ImportError is handled, it distinguishes a missing package from a broken one.
    """

    def __init__(self, package: str, extra: str) -> None:
        remedy, cause = f"pip install 'hazbot-gym[{extra}]'", sys.exc_info()[1]
        fault = "is not installed"
        if isinstance(cause, ImportError) and not isinstance(cause, ModuleNotFoundError):
            fault = f"is installed, but fails to import ({' '.join(str(cause).split())})"
        super().__init__(f"{package} {fault}: {remedy}")


class DoubtfulRecording(UserWarning):
    """A recording of people has a doubtful unit, rate or columns."""


class DoubtfulPlace(UserWarning):
    """A place has a path that is narrower or longer than the robot can drive."""

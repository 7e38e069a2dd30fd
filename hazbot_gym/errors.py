"""The errors that a user can meet; everything else is a bug and fails loudly."""

import sys


class HazbotError(Exception):
    """Root of all errors that hazbot_gym raises on purpose."""


class InvalidInput(HazbotError, ValueError):
    """A value from outside is not usable.

    The message is one line that names the field, what was given and what is allowed; the command
    line prints it as it is and exits with code 2.
    """


class UnknownKeyword(InvalidInput, TypeError):
    """A constructor has no such argument; as Python says it, for callers who try without it."""


class MissingExtra(HazbotError, ImportError):
    """An optional dependency cannot be imported; the message names the ``pip install`` that helps.

    Raised while an ImportError is handled, it tells a package that is not there from one that is
    broken.
    """

    def __init__(self, package: str, extra: str) -> None:
        remedy, cause = f"pip install 'hazbot-gym[{extra}]'", sys.exc_info()[1]
        fault = "is not installed"
        if isinstance(cause, ImportError) and not isinstance(cause, ModuleNotFoundError):
            fault = f"is installed, but fails to import ({' '.join(str(cause).split())})"
        super().__init__(f"{package} {fault}: {remedy}")


class DoubtfulRecording(UserWarning):
    """A recording of people is read, but signs are that its unit, rate or columns are not right."""


class DoubtfulPlace(UserWarning):
    """A place is read, but its path is narrower or longer than the robot can drive."""

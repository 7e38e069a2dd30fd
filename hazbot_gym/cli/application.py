"""The application that commands register with: version, interrupts, and errors of one line."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import signal
import sys
from collections.abc import Iterator
from typing import Annotated, Any

import typer

from hazbot_gym import __version__
from hazbot_gym.errors import HazbotError, InvalidInput
from hazbot_gym.utils import interrupts, terminal

# System errors of folders and disks given by the user.
_UNUSABLE = frozenset(
    (
        errno.EACCES,
        errno.EPERM,
        errno.EROFS,
        errno.ENOSPC,
        errno.EDQUOT,
        errno.EFBIG,
        errno.EIO,
        errno.EISDIR,
        errno.ENOTDIR,
        errno.ENAMETOOLONG,
        errno.ELOOP,
    )
)


# Resumption of interrupted commands.
_GO_ON = {
    "study": "; run the same command again to go on",
    "tune": "; run the same command again to go on",
    "train": "; run it again with --resume to go on",
}
_INTERRUPTED, _TERMINATED = 130, 143  # exit codes, as shells give them


class _Terminated(KeyboardInterrupt):
    """The process was asked to end, as by ``kill`` or a job scheduler."""


def _terminate(*_: object) -> None:
    raise _Terminated


class _OneLineErrors(typer.core.TyperGroup):
    """Commands with one-line errors on stderr and exit code 2."""

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """Parse the options before the command; show the help without arguments."""
        with _one_line_errors() if args else contextlib.nullcontext():
            for given, before in zip(args, ("", *args), strict=False):
                if not given or re.fullmatch("--[a-z-]+=", given):
                    name = given or (before if before.startswith("--") else "an argument")
                    raise InvalidInput(f"{name.strip('-=')} is empty, allowed is some text")
            return super().make_context(info_name, args, *more, **extra)

    def invoke(self, ctx: typer.Context) -> object:  # type: ignore[override]  # typer hides click's types
        try:
            with _one_line_errors():
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            how = _GO_ON.get(str(ctx.invoked_subcommand), "")
            typer.echo(f"hazbot: interrupted{how}", err=True)
            is_asked = isinstance(error, _Terminated)
            raise typer.Exit(_TERMINATED if is_asked else _INTERRUPTED) from None


@contextlib.contextmanager
def _one_line_errors() -> Iterator[None]:
    try:
        yield
        return
    except HazbotError as error:
        message = str(error)
    except typer.TyperException as error:  # an unknown option, an invalid number
        message = error.format_message()
    except OSError as error:
        if error.errno not in _UNUSABLE:
            raise
        message = f"{error.filename!r}: {error.strerror}" if error.filename else str(error.strerror)
    typer.echo(f"hazbot: {terminal.one_line(message)}", err=True)
    raise typer.Exit(2)


app = typer.Typer(
    cls=_OneLineErrors,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def main() -> None:
    """Run the command line."""
    # None if closed (``>&-``).
    sys.stdout, sys.stderr = (each or open(os.devnull, "w") for each in (sys.stdout, sys.stderr))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        terminal.tolerate(stream)
    terminal.warn_in_one_line()
    interrupts.repeat_ignored_interrupts()
    signal.signal(signal.SIGTERM, _terminate)  # so that worker processes end in order
    app(prog_name="hazbot")


def _show_version(is_wanted: bool) -> None:
    if is_wanted:
        typer.echo(f"hazbot {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Show the version and exit.", callback=_show_version, is_eager=True
        ),
    ] = False,
) -> None:
    """A gas-inspection robot among people: run, compare and measure speed policies."""

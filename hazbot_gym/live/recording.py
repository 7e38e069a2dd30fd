"""A run as a file: settings, actions and edits of the people; played, it is the same run."""

from __future__ import annotations

from typing import Annotated

from annotated_types import MaxLen
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from hazbot_gym import __version__
from hazbot_gym.config.parameters import MOST_STEPS
from hazbot_gym.config.section import first_error
from hazbot_gym.errors import InvalidInput
from hazbot_gym.live.run import Edit, Run
from hazbot_gym.live.settings import Settings

Decision = Annotated[int, Field(ge=0, le=MOST_STEPS)]
Action = Annotated[float, Field(ge=-1.000001, le=1.000001)]
Edits = dict[int, tuple[Edit, ...]]  # by the decision before which they are made


class RunFile(BaseModel):
    """A recorded run."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    version: str = __version__  # of the package that recorded it
    settings: Settings
    actions: Annotated[tuple[Action, ...], MaxLen(MOST_STEPS)]
    edits: tuple[tuple[Decision, tuple[Edit, ...]], ...] = ()


def text_of(settings: Settings, run: Run, edits: Edits) -> str:
    """Return a run so far as the text of a file."""
    made = tuple((decision, edits[decision]) for decision in sorted(edits))
    file = RunFile(settings=settings, actions=tuple(run.actions), edits=made)
    return file.model_dump_json()


def read(text: str) -> RunFile:
    """Return the run of a file's text.

    Raises:
        InvalidInput: It is no such file.
    """
    try:
        return RunFile.model_validate_json(text)
    except ValidationError as error:
        raise InvalidInput(f"run: {first_error(error, RunFile)}") from None

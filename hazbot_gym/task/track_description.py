"""The description beside a track file: JSON of the same name with rate, unit, columns and place.

Unknown fields are ignored, unless they resemble a known field: an ignored ``unit`` would give a
wrong recording.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AliasChoices, BaseModel, ConfigDict, Field, ValidationError

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.table import MOST_WALLS, Unit

FARTHEST_M = 1e6  # of a wall or a corridor from the origin
_CLOSE = 0.8  # similarity of names by difflib
_OTHER_NAMES = {  # synonyms of fields, which difflib does not find
    **dict.fromkeys(("framerate", "frame_rate", "rate", "frequency", "hz", "freq"), "fps"),
    **dict.fromkeys(("frames_per_second", "sampling_rate", "sample_rate"), "fps"),
    **dict.fromkeys(("scale", "meters_per_pixel", "m_per_px"), "metres_per_pixel"),
    **dict.fromkeys(("order", "column_order", "header"), "columns"),
    **dict.fromkeys(("obstacles", "boundaries"), "walls"),
}

_Metres = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
LEAST_SCALE, MOST_SCALE = 1e-6, 1e6  # frames a second, or meters a pixel
Scale = Annotated[float, Field(gt=0, le=MOST_SCALE)]
_Point = tuple[_Metres, _Metres]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class Geometry(_Strict):
    """The place in a description [m]."""

    corridor_axis: Literal["x", "y"] | None = None
    corridor_x: _Point | None = None
    corridor_y: _Point | None = None
    walls: Annotated[list[tuple[_Point, _Point]], Field(max_length=MOST_WALLS)] = []


class Source(_Strict):
    """Origin of a table."""

    repo: str = ""
    commit: str = ""
    path: str = ""
    original_file: str = ""

    def __str__(self) -> str:
        return " ".join(part for part in (self.repo, self.commit, self.path) if part)


class Description(_Strict):
    """The known fields of a description."""

    name: str = ""
    fps: Scale | None = None
    units: Unit | None = None
    metres_per_pixel: Scale | None = None
    columns: str | list[str] | None = None
    geometry: Geometry = Geometry()
    source: str | Source = ""
    licence: str = Field("", validation_alias=AliasChoices("licence", "license"))
    citation: str = ""


def read_description(path: Path) -> Description:
    """Read a description; empty without a file.

    Raises:
        InvalidInput: the file is not JSON, or a field is not usable or looks misspelled.
    """
    if not path.exists():
        return Description()
    try:
        data = path.read_bytes()
        content = json.loads(data, object_pairs_hook=_once)
        _check_names(content, (*Description.model_fields, "license"))
        if isinstance(content, dict) and isinstance(content.get("geometry"), dict):
            _check_names(content["geometry"], Geometry.model_fields)
        return Description.model_validate_json(data)
    except OSError as error:
        raise InvalidInput(f"{path.name}: cannot be read ({error.strerror})") from None
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        words = [word for word in (path.name, field, first["msg"]) if word]
        raise InvalidInput(": ".join(words)) from None
    except InvalidInput as fault:
        raise InvalidInput(f"{path.name}: {fault}") from None
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"{path.name}: Invalid JSON: {error!s:.100}") from None


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    content = dict(pairs)
    if len(content) < len(pairs):
        names = [name for name, _ in pairs]
        raise InvalidInput(f"{next(n for n in names if names.count(n) > 1)!r} is given twice")
    return content


def _check_names(content: object, known: Collection[str]) -> None:
    """Reject unknown names that resemble known ones."""
    if not isinstance(content, dict):
        return
    for name in content.keys() - set(known):
        plain = name.lower().replace("-", "_").replace(" ", "_")
        close = difflib.get_close_matches(plain, known, n=1, cutoff=_CLOSE)
        meant = _OTHER_NAMES.get(plain) or next(iter(close), None)
        if meant in known:
            raise InvalidInput(f"{name!r} is not a field; {meant!r} is")

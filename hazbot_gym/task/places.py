"""Built-in places by name with length options, and user places from YAML (``place_data``)."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from pathlib import Path

from pydantic import ValidationError

from hazbot_gym.config.section import first_error
from hazbot_gym.core.state import Place
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.place_data import (
    RUN_OUT_M,
    CircleData,
    PathData,
    PlaceData,
    RouteData,
    Segment,
    build_place,
)
from hazbot_gym.task.wall_files import read_walls, wall_files
from hazbot_gym.utils.yaml_loader import read_yaml

CIRCLE_RADIUS_M = 3.431  # of the paper's circle: Table 3; the text says about 3.5 m


def open_floor(*, length_m: float = 12.0, end_wall_m: float = 0.0) -> PlaceData:
    """Return an open floor with a straight path: the paper's simulations (section 5.1).

    Args:
        length_m: Length of the path.
        end_wall_m: Distance of a transverse wall behind the path's end; 0: none.
    """
    wall_m = length_m + end_wall_m
    return PlaceData(
        name="open",
        walls=((wall_m, -2.0, wall_m, 2.0),) if end_wall_m else (),
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        along_room_m=1.5,
    )


def corridor(
    *, width_m: float = 2.4, length_m: float = 12.0, side_door_m: float = 1.6
) -> PlaceData:
    """Return a straight corridor with a door on either side, halfway, for people to cross."""
    half, middle, door = width_m / 2, length_m / 2, side_door_m / 2
    walls: list[Segment] = []
    for y in (-half, half):
        outward = 3.0 if y > 0 else -3.0
        walls += [
            (-RUN_OUT_M, y, middle - door, y),
            (middle + door, y, length_m + RUN_OUT_M, y),
            (middle - door, y, middle - door, y + outward),
            (middle + door, y, middle + door, y + outward),
        ]
    across = half + 2.8
    return PlaceData(
        name="corridor",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        routes=[
            RouteData(points=[(middle, -across), (middle, across)], room_m=door - 0.35),
            RouteData(points=[(middle, across), (middle, -across)], room_m=door - 0.35),
        ],
        along_room_m=half - 0.25,
    )


def intersection(
    *, width_m: float = 2.0, side_width_m: float = 2.0, length_m: float = 12.0
) -> PlaceData:
    """Return a crossing of two corridors with occluding corners."""
    half, side, middle = width_m / 2, side_width_m / 2, length_m / 2
    walls: list[Segment] = []
    for y, far in ((-half, -half - RUN_OUT_M), (half, half + RUN_OUT_M)):
        walls += [
            (-RUN_OUT_M, y, middle - side, y),
            (middle + side, y, length_m + RUN_OUT_M, y),
            (middle - side, y, middle - side, far),
            (middle + side, y, middle + side, far),
        ]
    ends = half + RUN_OUT_M - 0.5
    return PlaceData(
        name="intersection",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        routes=[
            RouteData(points=[(middle, -ends), (middle, ends)], room_m=side - 0.3),
            RouteData(points=[(middle, ends), (middle, -ends)], room_m=side - 0.3),
        ],
        along_room_m=half - 0.25,
    )


def doorway(*, width_m: float = 2.4, door_m: float = 1.2, length_m: float = 12.0) -> PlaceData:
    """Return a corridor with a doorway halfway, wide enough for one person or robot."""
    half, middle, door = width_m / 2, length_m / 2, door_m / 2
    return PlaceData(
        name="doorway",
        walls=[
            (-RUN_OUT_M, -half, length_m + RUN_OUT_M, -half),
            (-RUN_OUT_M, half, length_m + RUN_OUT_M, half),
            (middle, -half, middle, -door),
            (middle, door, middle, half),
        ],
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        along_room_m=max(door - 0.3, 0.05),
    )


def circle(*, radius_m: float = CIRCLE_RADIUS_M) -> PlaceData:
    """Return the paper's circle (Table 3) in an open hall, with people crossing it."""
    r, reach = radius_m, radius_m + 5.0
    return PlaceData(
        name="circle",
        path=PathData(circle=CircleData(center=(0.0, r), radius_m=r)),
        routes=[
            RouteData(points=[(-reach, 0.5 * r), (reach, 0.5 * r)], room_m=0.6),
            RouteData(points=[(reach, 1.5 * r), (-reach, 1.5 * r)], room_m=0.6),
            RouteData(points=[(0.6 * r, -4.0), (0.6 * r, 2 * r + 4.0)], room_m=0.6),
            RouteData(points=[(-0.6 * r, 2 * r + 4.0), (-0.6 * r, -4.0)], room_m=0.6),
        ],
        along_room_m=0.8,
    )


def aisle(*, width_m: float = 2.2, leg_m: float = 7.0) -> PlaceData:
    """Return an L-shaped aisle with a blind corner and protruding shelf ends."""
    half, run = width_m / 2, RUN_OUT_M
    shelf = 0.3  # protrusion of a shelf end
    walls: list[Segment] = [
        (-run, -half, leg_m + half, -half),  # outer side
        (leg_m + half, -half, leg_m + half, leg_m + run),
        (-run, half, leg_m - half, half),  # inner side
        (leg_m - half, half, leg_m - half, leg_m + run),
        (0.4 * leg_m, -half, 0.4 * leg_m, -half + shelf),  # shelf ends
        (0.6 * leg_m, -half, 0.6 * leg_m, -half + shelf),
        (0.4 * leg_m, -half + shelf, 0.6 * leg_m, -half + shelf),
        (leg_m - half, 0.6 * leg_m, leg_m - half + shelf, 0.6 * leg_m),
        (leg_m - half, 0.8 * leg_m, leg_m - half + shelf, 0.8 * leg_m),
        (leg_m - half + shelf, 0.6 * leg_m, leg_m - half + shelf, 0.8 * leg_m),
    ]
    return PlaceData(
        name="aisle",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (leg_m, 0.0), (leg_m, leg_m)], corner_radius_m=1.0),
        along_room_m=half - shelf - 0.25,
    )


PLACES: dict[str, Callable[..., PlaceData]] = {
    "open": open_floor,
    "corridor": corridor,
    "intersection": intersection,
    "doorway": doorway,
    "circle": circle,
    "aisle": aisle,
}


def load_place(name: str, options: Mapping[str, float] | None = None) -> Place:
    """Return a built-in place by name, or one from a YAML file, validated.

    Args:
        name: A name of ``PLACES``, or the path of a ``.yaml`` file.
        options: Lengths of a built-in place, by name [m].

    Raises:
        InvalidInput: The name, an option or the file's content cannot be used.
    """
    if is_file(name):
        if options:
            raise InvalidInput("place_options: given, but a place from a file takes none")
        return build_place(_read_place(Path(name)))
    if name not in PLACES:
        allowed = ", ".join(PLACES)
        hint = "; its path and walls are said in one" if name.lower().endswith(".wkt") else ""
        raise InvalidInput(f"place: given {name!r}, allowed are {allowed} or a .yaml file{hint}")
    return _built_in(name, tuple((options or {}).items()))


@functools.lru_cache(maxsize=64)  # of each place and its lengths, as building takes 40 ms
def _built_in(name: str, options: tuple[tuple[str, float], ...]) -> Place:
    known = inspect.signature(PLACES[name]).parameters
    for option, value in options:
        if option not in known:
            raise InvalidInput(f"place_options: given {option!r}, {name} takes {', '.join(known)}")
        if not 0.0 < value < 1000.0:
            raise InvalidInput(
                f"place_options.{option}: given {value}, allowed is 0 < length < 1000"
            )
    try:
        data = PLACES[name](**dict(options))
    except ValidationError as error:  # inconsistent lengths, such as a negative remainder
        raise InvalidInput(
            f"place_options: {name} is impossible, {first_error(error, PlaceData)}"
        ) from error
    return build_place(data)


def place_files(name: str) -> list[Path]:
    """Return the input files of a place; none for a built-in place."""
    if not is_file(name):
        return []
    path = Path(name)
    walls = read_yaml(path, "place").get("walls")
    return [path, *(wall_files(_beside(path, walls)) if isinstance(walls, str) else [])]


def is_file(name: str) -> bool:
    """Return True if a place is given by a file."""
    return name.endswith((".yaml", ".yml"))


def _read_place(path: Path) -> PlaceData:
    content = read_yaml(path, "place")
    if "image" in content and "resolution" in content:
        raise InvalidInput(
            f"place {path}: given a map of map_server, which has no path: write a place file with "
            f"'walls: {path.name}' and a path"
        )
    walls = content.get("walls")
    try:
        if isinstance(walls, str):
            content["walls"] = read_walls(_beside(path, walls))
        return PlaceData.model_validate(content)
    except ValidationError as error:
        raise InvalidInput(f"place {path}: {first_error(error, PlaceData)}") from error


def _beside(path: Path, walls: str) -> Path:
    """Return the wall file named in a place file."""
    if Path(walls).suffix.lower() not in (".wkt", ".yaml", ".yml"):
        raise InvalidInput(
            f"place {path}: walls: given {walls!r}, allowed are a list of walls, a .wkt file or "
            "the .yaml file of a map"
        )
    return path.parent / walls

"""Walls from files: polygons as WKT, and occupancy grids of ROS's map_server.

A grid is a YAML file that names an image. A pixel of value v is occupied if its probability p
exceeds ``occupied_thresh``: p = (255 - v)/255, or v/255 with ``negate``. ``origin`` is the pose (x,
y, yaw) of the lower left corner. Walls are the simplified outlines of occupied areas.
Source: http://wiki.ros.org/map_server, section 2 (trinary and scale; raw is rejected).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt, Le
from pydantic import ConfigDict, ValidationError

from hazbot_gym.config.section import Loose, Section, first_error
from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.utils.yaml_loader import read_yaml

if TYPE_CHECKING:
    from shapely import Geometry

MOST_WALLS = 5000  # every step looks at each of them
MOST_BYTES = 2**24  # of a WKT file
MOST_CELLS = 2**24  # of a grid
MOST_RUNS = 100_000  # of occupied cells in the rows of a grid
TOLERANCE = 0.75  # tolerance of outlines in cells, which smooths diagonal steps


class RosMap(Section):
    """YAML file of a map; newer versions of map_server may have more fields."""

    model_config = ConfigDict(extra="ignore")

    image: str
    resolution: Annotated[float, Gt(0)]  # m per pixel
    origin: Annotated[tuple[float, float, float], Loose]  # x, y [m], yaw [rad]
    negate: Annotated[int, Ge(0), Le(1)] = 0
    occupied_thresh: Annotated[float, Gt(0), Le(1)] = 0.65
    mode: Literal["trinary", "scale"] = "trinary"


def read_walls(path: Path) -> list[tuple[float, ...]]:
    """Return the walls of a ``.wkt`` file or of a map's ``.yaml``: x1, y1, x2, y2 [m].

    Raises:
        InvalidInput: The file cannot be used, or holds too many walls or none.
        MissingExtra: shapely or pillow is not installed.
    """
    lines = _wkt_lines(path) if path.suffix.lower() == ".wkt" else _map_lines(path)
    walls = [tuple(wall) for line in lines for wall in np.hstack([line[:-1], line[1:]]).tolist()]
    walls = [wall for wall in walls if wall[:2] != wall[2:]]
    if not 0 < len(walls) <= MOST_WALLS:
        raise InvalidInput(f"walls: {path}: {len(walls)} walls, allowed are 1 to {MOST_WALLS}")
    return walls


def wall_files(path: Path) -> list[Path]:
    """Return the input files of ``read_walls``: the file, and the image of a map."""
    if path.suffix.lower() == ".wkt":
        return [path]
    return [path, path.parent / _read_map(path).image]


def _shapely() -> Any:
    try:
        import shapely
    except ImportError as error:
        raise MissingExtra("shapely", "places") from error
    return shapely


# --- WKT -----------------------------------------------------------------------------------------


def _wkt_lines(path: Path) -> Iterator[Floats]:
    """Yield the rings and lines (n, 2) of a file's geometries."""
    shapely = _shapely()
    text = _read_text(path)
    try:
        geometries = [shapely.from_wkt(text)]
    except shapely.errors.ShapelyError:  # several, one a line
        geometries = [_geometry(path, n, line) for n, line in enumerate(text.splitlines(), 1)]
    for geometry in geometries:
        yield from _lines(path, geometry)


def _read_text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise InvalidInput(f"walls: {path} is larger than {MOST_BYTES >> 20} MiB")
        return data.decode("utf-8-sig").strip()
    except OSError as error:
        raise InvalidInput(f"walls: cannot read {path} ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InvalidInput(f"walls: {path} is not a text file") from error


def _geometry(path: Path, number: int, line: str) -> Geometry | None:
    shapely = _shapely()
    try:
        return shapely.from_wkt(line) if line.strip() else None
    except shapely.errors.ShapelyError as error:
        fault = str(error).splitlines()[0]
        raise InvalidInput(f"walls: {path}, line {number}: is not WKT ({fault:.80})") from error


def _lines(path: Path, geometry: Geometry | None) -> Iterator[Floats]:
    shapely = _shapely()
    for part in shapely.get_parts(geometry) if geometry is not None else ():
        if part.geom_type == "Polygon":
            rings = shapely.get_rings(part)
        elif part.geom_type in ("LineString", "LinearRing"):
            rings = [part]
        elif part.geom_type.startswith(("Multi", "GeometryCollection")):
            yield from _lines(path, part)
            continue
        else:
            raise InvalidInput(
                f"walls: {path}: given a {part.geom_type}, allowed are polygons and lines"
            )
        for ring in rings:
            points = shapely.get_coordinates(ring)
            if not np.isfinite(points).all():
                raise InvalidInput(f"walls: {path}: a coordinate is not a finite number")
            yield points


# --- occupancy grids -----------------------------------------------------------------------------


def _map_lines(path: Path) -> Iterator[Floats]:
    """Yield the outlines (n, 2) of occupied areas in a map [m]."""
    shapely = _shapely()
    given = _read_map(path)
    is_occupied = _occupied(path.parent / given.image, given)
    outline = shapely.boundary(shapely.union_all(_runs(is_occupied)))
    x, y, yaw = given.origin
    turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    for ring in shapely.get_parts(outline):
        corners = _simplified(shapely.get_coordinates(ring))
        yield corners * given.resolution @ turn + (x, y)


def _simplified(ring: Floats) -> Floats:
    """Return a ring (n, 2) with fewer corners; a rectangle keeps its four."""
    shapely = _shapely()
    for tolerance in (0.0, 0.0, TOLERANCE):  # the first point is kept, so it is rotated
        if tolerance == 0.0 or len(ring) > 5:
            kept = shapely.get_coordinates(shapely.simplify(shapely.linearrings(ring), tolerance))
            ring = np.vstack([kept[1:], kept[1]])
    return ring


def _read_map(path: Path) -> RosMap:
    try:
        return RosMap.model_validate(read_yaml(path, "walls"))
    except ValidationError as error:
        raise InvalidInput(f"walls: {path}: {first_error(error, RosMap)}") from error


def _occupied(path: Path, given: RosMap) -> npt.NDArray[np.bool_]:
    """Return True for occupied cells, the lowest row first."""
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError as error:
        raise MissingExtra("pillow", "places") from error
    try:
        with Image.open(path) as image:
            if image.width * image.height > MOST_CELLS:
                raise InvalidInput(
                    f"walls: {path} has {image.width} x {image.height} pixels, allowed are "
                    f"{MOST_CELLS:,} in all"
                )
            values = np.asarray(image.convert("RGB"), dtype=np.float64).mean(axis=2)
    except (UnidentifiedImageError, OSError, ValueError, Image.DecompressionBombError) as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"walls: cannot read the image {path} ({error!s:.80})") from error
    probability = values / 255.0 if given.negate else (255.0 - values) / 255.0
    is_occupied: npt.NDArray[np.bool_] = probability[::-1] > given.occupied_thresh
    return is_occupied


def _runs(is_occupied: npt.NDArray[np.bool_]) -> npt.NDArray[np.object_]:
    """Return a box for each run of occupied cells in a row, in cells from the lower left corner."""
    padded = np.pad(is_occupied, ((0, 0), (1, 1))).astype(np.int8)
    edges = np.diff(padded, axis=1)
    rows, begins = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    if len(rows) > MOST_RUNS:
        raise InvalidInput(
            f"walls: the image has {len(rows):,} runs of occupied cells in its rows, allowed are "
            f"{MOST_RUNS:,}: clear it of speckles"
        )
    boxes: npt.NDArray[np.object_] = _shapely().box(begins, rows, ends, rows + 1)
    return boxes

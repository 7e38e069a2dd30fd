"""Section 5.2: tracking the circle."""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.config import make_config
from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.pid import PLANTS
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.circle import (
    RADIUS_M,
    TABLE_3,
    Figures,
    Lap,
    Point,
    converged_s,
    critical_points,
    drive_lap,
    figures,
    paper_drive,
    printed_errors,
)
from hazbot_gym.paper.figures import circle as pictures
from hazbot_gym.paper.numbers import reported

LOOPS = {"fuzzy-PID": "fuzzy_pid", "PID": "pid"}
NOISE = {"wheel_noise_radps": 0.01, "heading_noise_rad": 0.002}  # SPEC section 6
NOISY_BANDS = (0.001, 0.005, 0.01)


def chapter(quick: bool) -> Chapter:
    """Run the section."""
    laps = {name: drive_lap(paper_drive(wheel_loop=loop)) for name, loop in LOOPS.items()}
    here = {name: figures(lap) for name, lap in laps.items()}
    points = critical_points(laps["fuzzy-PID"])
    plants = {
        f"{plant}, {name}": figures(drive_lap(paper_drive(plant=plant, wheel_loop=loop)))
        for plant in PLANTS
        for name, loop in LOOPS.items()
    }
    others = variants()
    noisy = {name: noisy_laps(loop, 20 if quick else 200) for name, loop in LOOPS.items()}
    robot = make_config(scenario="circle")
    decimals = -round(np.log10(0.001))
    return Chapter(
        number="5.2",
        title="Combination Autonomous Behavior Strategy: the circle",
        here={
            "circle_sampling_s": robot.clock.physics_s,
            "circle_decimals": decimals,
            "circle_radius_m": RADIUS_M,
            "circle_start_x_m": 0.0,
            "circle_start_y_m": 0.0,
            "circle_start_theta_rad": 0.0,
            **_four("fuzzy", here["fuzzy-PID"]),
            **_four("pid", here["PID"]),
            **_table_3(points),
        },
        record={
            "plants": {name: found._asdict() for name, found in plants.items()},
            "variants": {name: found._asdict() for name, found in others.items()},
            "noise": noisy,
            "table_3": [point._asdict() for point in points],
            "table_3_printed_errors_m": printed_errors(),
        },
        text=_text(here, noisy, points),
        tables=(
            _figure_table("All plants of SPEC section 5, beside the paper", plants),
            _figure_table("Plant B with one thing changed", others),
            _noise_table(noisy),
            _point_table(points),
        ),
        pictures=_pictures(laps, points),
    )


def variants() -> dict[str, Figures]:
    """Return the four numbers on plant B with one thing changed, for both controllers."""
    changes: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
        "rules see wanted minus actual (s = +1)": ({"fuzzy": FuzzyPid(sign=1.0)._asdict()}, {}),
        "symmetric tables": ({"tables": "symmetric"}, {}),
        "0.3 m/s": ({"nominal_speed_mps": 0.3}, {}),
        "radius 3.5 m": ({}, {"radius_m": 3.5}),
        "steps of 0.005 s": ({}, {"physics_s": 0.005}),
        "steps of 0.02 s": ({}, {"physics_s": 0.02}),
        "|u| at most 10": ({"plant": PLANTS["B"]._replace(u_max=10.0)._asdict()}, {}),
    }
    found = {}
    for what, (drive, lap) in changes.items():
        only_fuzzy = "fuzzy" in drive or "tables" in drive
        for name, loop in LOOPS.items():
            if not (only_fuzzy and loop == "pid"):
                driven = drive_lap(paper_drive(wheel_loop=loop, **drive), **lap)
                found[f"{what}, {name}"] = figures(driven)
    return found


def noisy_laps(loop: str, seeds: int) -> dict[str, dict[str, float]]:
    """Return mean and deviation of the numbers over noise seeds."""
    laps = [drive_lap(paper_drive(wheel_loop=loop, **NOISE), key=key) for key in range(seeds)]
    columns: dict[str, list[float]] = {
        "position_max_m": [float(lap.position_m.max()) for lap in laps],
        "angle_max_rad": [float(lap.angle_rad.max()) for lap in laps],
    }
    for band in NOISY_BANDS:
        columns[f"position below {band:g} m [s]"] = [
            converged_s(lap.time_s, lap.position_m, band) for lap in laps
        ]
        columns[f"angle below {band:g} rad [s]"] = [
            converged_s(lap.time_s, lap.angle_rad, band) for lap in laps
        ]
    return {
        name: {"mean": float(np.mean(values)), "sd": float(np.std(values, ddof=1))}
        for name, values in columns.items()
    } | {"seeds": {"mean": float(seeds), "sd": 0.0}}


def _four(name: str, found: Figures) -> dict[str, float]:
    return {
        f"circle_{name}_position_max_m": found.position_max_m,
        f"circle_{name}_angle_max_rad": found.angle_max_rad,
        f"circle_{name}_position_converged_s": found.position_converged_s,
        f"circle_{name}_angle_converged_s": found.angle_converged_s,
    }


def _table_3(points: list[Point]) -> dict[str, float]:
    return {
        f"table3_{row}_{name}": value
        for row, point in enumerate(points, start=1)
        for name, value in point._asdict().items()
    }


def _paper(name: str) -> Figures:
    numbers = reported().numbers
    short = {"fuzzy-PID": "fuzzy", "PID": "pid"}[name]
    return Figures(*(numbers[f"circle_{short}_{field}"].paper for field in Figures._fields))


def _text(
    here: dict[str, Figures], noisy: dict[str, dict[str, dict[str, float]]], points: list[Point]
) -> tuple[str, ...]:
    fuzzy, fixed, paper = here["fuzzy-PID"], here["PID"], _paper("fuzzy-PID")
    at_most = noisy["fuzzy-PID"]["position_max_m"]
    never = noisy["fuzzy-PID"][f"position below {NOISY_BANDS[0]:g} m [s]"]
    late = noisy["fuzzy-PID"][f"position below {NOISY_BANDS[2]:g} m [s]"]
    ours, theirs = np.divide(fuzzy, fixed), np.divide(paper, _paper("PID"))
    return (
        f"The robot stands at the start of a circle of {RADIUS_M} m while its target sets off at "
        "0.5 m/s: that is how an initial error of zero can become one of a tenth of a metre. An "
        "error has converged when it stays below 0.001, the third decimal that the paper resolves. "
        "The paper prints no motor; plant B is the one of SPEC section 5 that comes nearest to the "
        f"fuzzy-PID: {fuzzy.position_max_m:.3f} m, {fuzzy.angle_max_rad:.3f} rad, "
        f"{fuzzy.position_converged_s:.2f} s and {fuzzy.angle_converged_s:.2f} s. It is a fit, "
        "not a validation.",
        "With the same plant the PID comes to "
        f"{fixed.position_max_m:.3f} m, {fixed.angle_max_rad:.3f} rad, "
        f"{fixed.position_converged_s:.2f} s and {fixed.angle_converged_s:.2f} s. The ratios of "
        "fuzzy-PID to PID are "
        f"{', '.join(f'{ratio:.2f}' for ratio in ours)} here and "
        f"{', '.join(f'{ratio:.2f}' for ratio in theirs)} in the paper. No plant "
        "was found that gives all eight.",
        "With the sensor noise of Table 2 the position error last exceeds 0.001 m at "
        f"{never['mean']:.1f} ± {never['sd']:.1f} s (mean and deviation over "
        f"{noisy['fuzzy-PID']['seeds']['mean']:.0f} seeds) and {NOISY_BANDS[2]:g} m at "
        f"{late['mean']:.1f} ± {late['sd']:.2f} s: the third decimal lies within the noise, and "
        "when an error converges to it is luck. The largest position error hardly moves, "
        f"{at_most['mean']:.4f} ± {at_most['sd']:.4f} m.",
        "Of Table 3 three entries contradict the others: the error of row 2 follows from its "
        f"coordinates as {printed_errors()[1]:.4f} m (printed 0.014); in row 4 the sign of y is "
        "wrong, or the robot would be 6.854 m off the circle; in row 5 x_r = 0.002 and x = -0.002 "
        f"would make an error of {printed_errors()[4]:.3f} m, printed 0. The other points come out "
        "to millimetres, but for row 2, where the printed robot is farther ahead of its target: "
        f"{TABLE_3[1].position:g} m, here {points[1].position:.3f} m. The angle error there is the "
        f"printed one ({points[1].angle:.3f} rad).",
    )


def _figure_table(caption: str, found: dict[str, Figures]) -> Table:
    paper = {f"paper, {name}": _paper(name) for name in LOOPS}
    rows = [
        (
            name,
            f"{each.position_max_m:.3f}",
            f"{each.angle_max_rad:.3f}",
            f"{each.position_converged_s:.2f}",
            f"{each.angle_converged_s:.2f}",
        )
        for name, each in {**paper, **found}.items()
    ]
    head = ("", "largest position error [m]", "largest angle error [rad]",
            "position converged [s]", "angle converged [s]")  # fmt: skip
    return Table(caption, head, rows)


def _noise_table(noisy: dict[str, dict[str, dict[str, float]]]) -> Table:
    names = [name for name in noisy["PID"] if name != "seeds"]
    return Table(
        f"Plant B with the noise of Table 2, {noisy['PID']['seeds']['mean']:.0f} seeds",
        ("", *(f"{name}: mean ± sd" for name in LOOPS)),
        [
            (name, *(f"{found[name]['mean']:.4g} ± {found[name]['sd']:.2g}"
                     for found in noisy.values()))
            for name in names
        ],
    )  # fmt: skip


def _point_table(points: list[Point]) -> Table:
    head = ("point", *(f"{name}, {who}" for name in ("x_r", "y_r", "x", "y", "position error",
            "angle error") for who in ("paper", "here")))  # fmt: skip
    rows = []
    for number, (printed, found) in enumerate(zip(TABLE_3, points, strict=True), start=1):
        pairs = zip(printed, found, strict=True)
        rows.append((str(number), *(f"{value:.3f}" for pair in pairs for value in pair)))
    return Table("Table 3 [m, rad]", head, rows)


def _pictures(laps: dict[str, Lap], points: list[Point]) -> tuple[Picture, ...]:
    paper = {name: tuple(_paper(name)) for name in LOOPS}
    return (
        Picture(
            "circle-trajectory",
            "Figure 18",
            "Target circle and the robot's trajectory with the fuzzy-PID, its distance from the "
            "target enlarged ten times; squares are the critical points of Table 3.",
            pictures.trajectory(laps["fuzzy-PID"], points, RADIUS_M),
        ),
        Picture(
            "circle-errors",
            "Figure 20",
            "Position error (a) and angle error (b) over time with both controllers on plant B; "
            "dashed: the paper's largest errors, dotted: when it says that they converged.",
            pictures.errors(laps, paper),
        ),
        Picture(
            "circle-convergence",
            "",
            "The same errors on a logarithmic scale: both controllers lose them at the same rate, "
            "that of the tracking law, and differ in where they start from.",
            pictures.late_errors(laps),
        ),
    )

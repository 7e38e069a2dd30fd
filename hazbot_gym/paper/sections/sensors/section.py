"""Section 5.1, first part: sensor accuracy (Table 2)."""

from __future__ import annotations

import math

from hazbot_gym.config import Config
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.control_system import plots
from hazbot_gym.paper.sections.sensors.experiment import (
    HEADING_RAD,
    READINGS,
    TABLE_2,
    WALL_M,
    WHEEL_MPS,
    half_range,
    measure,
)

SEEDS = 200


def chapter(quick: bool) -> Chapter:
    """Run the section; it is the same in either form."""
    found = measure(SEEDS)
    hub, wall, heading = found.errors()
    config = Config()
    means = [float(column.mean()) for column in found]
    widths = (half_range(hub), half_range(wall), half_range(heading))
    rows = range(1, len(TABLE_2) + 1)
    return Chapter(
        number="5.1a",
        title="The sensor experiment",
        here={
            **{f"table2_hub_{row}": means[0] for row in rows},
            **{f"table2_angle_{row}": means[1] for row in rows},
            **{f"table2_ultra_{row}": means[2] for row in rows},
            "sensor_error_hub_mps": widths[0],
            "sensor_error_angle_rad": widths[2],
            "sensor_error_ultra_m": widths[1],
            "sensor_sampling_s": config.clock.decision_s,
            "sensor_wheel_speed_mps": WHEEL_MPS,
            "sensor_angle_deg": round(math.degrees(HEADING_RAD), 9),
            "sensor_wall_m": WALL_M,
        },
        record={"means": means, "half_widths": list(widths), "readings": SEEDS * READINGS},
        text=(
            "The paper measures a driving wheel at 0.5 m/s, the robot's angle at 90 deg, and a "
            'wall at 1 m, and prints five readings of each. The headings of the columns "Angle '
            '(rad)" and "Ultra (m)" are swapped: 1.57 is a right angle in radians, and 1.00 is '
            "the distance to the wall. With the headings corrected, table and text agree, with "
            "errors of ±0.002 m/s, ±0.002 rad, and ±0.03 m, which are the half-widths of the "
            "sensor noise in this library. The readings are compared by the mean of "
            f"{SEEDS * READINGS} simulated readings, and the half-widths by their extremes: "
            f"{widths[0]:.4f} m/s, {widths[2]:.4f} rad, and {widths[1]:.4f} m.",
        ),
        tables=(
            Table(
                "Table 2 with corrected column headings",
                ("point", "hub motor [m/s]", "distance [m]", "heading [rad]"),
                [
                    (str(row), *(f"{value:.3f}" for value in printed))
                    for row, printed in enumerate(TABLE_2, start=1)
                ],
            ),
        ),
        pictures=(
            Picture(
                "sensor-readings",
                "Table 2",
                "Simulated readings (blue) and the five printed readings (crosses), offset "
                "vertically; gray: the half-width stated in the text.",
                plots.readings(found, (0.002, 0.03, 0.002)),
            ),
        ),
    )

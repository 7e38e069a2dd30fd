"""Section 5.2, second part: a human enters while the robot tracks the circle (Figure 19)."""

from __future__ import annotations

from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.combination.experiment import combine
from hazbot_gym.paper.sections.control_system import plots
from hazbot_gym.paper.sections.meetings.experiment import EVENT_NAMES, spread

LAST_S = 10.0  # last part of a lap, for the final tracking error


def chapter(quick: bool) -> Chapter:
    """Run the section; the paper reports no number of it."""
    found = combine(20 if quick else 200)
    spreads = spread(found.found)
    (rms, rms_alone), (largest, largest_alone) = found.tracking_rms_m(), found.largest_m()
    with_s, alone_s = found.lap_s()
    met_s = spreads["decelerates_s"]["mean"]
    (met, met_alone), (final, final_alone) = found.largest_m(met_s), found.final_m(LAST_S)
    return Chapter(
        number="5.2b",
        title="The combination: a human enters while the robot tracks the circle",
        here={},
        record={
            "events": spreads,
            "position_rms_m": {"with": rms, "alone": rms_alone},
            "position_max_m": {"with": largest, "alone": largest_alone},
            "position_max_from_meeting_m": {"with": met, "alone": met_alone},
            "position_max_at_the_end_m": {"with": final, "alone": final_alone},
            "arrivals": found.arrivals(),
            "lap_s": {"with": with_s, "alone": alone_s},
            "seeds": len(found.runs),
        },
        text=(
            "Figure 19 shows the combination and no numbers, and where the human walked is not "
            "printed. In the scenario circle+human somebody comes the other way beside the circle "
            "at 0.5 m/s; the robot has the drive in earnest on plant B, with slew limits and the "
            f"noise of Table 2, over {len(found.runs)} seeds. It is assessed as encountering; the "
            f"robot decelerates on its path at {spreads['decelerates_s']['mean']:.1f} s and stands "
            f"from {spreads['stops_s']['mean']:.1f} s on; as the human moves away it returns to "
            f"its speed, which it has again at {spreads['recovers_s']['mean']:.1f} s, and goes on "
            "along the circle. While the human is within 1.5 m it moves for "
            f"{spreads['moving_inside_s']['mean']:.1f} s.",
            "To slow down and to start again costs tracking: from when the robot decelerates on, "
            f"the position error reaches {met:.3f} m instead of {met_alone:.3f} m alone. Over the "
            f"whole lap, its start from rest included, it reaches {largest:.3f} m and "
            f"{largest_alone:.3f} m (with slew limits the start is gentler than in section 5.2), "
            f"with an RMS of {1e3 * rms:.0f} mm and {1e3 * rms_alone:.0f} mm. In the last "
            f"{LAST_S:g} s it is at most {1e3 * final:.1f} mm and {1e3 * final_alone:.1f} mm: "
            f"the robot is on its circle again. {100.0 * found.arrivals():.0f} % of the laps are "
            f"driven to their end, in {with_s:.1f} s instead of {alone_s:.1f} s.",
        ),
        tables=(
            Table(
                f"Over {len(found.runs)} noise seeds",
                ("event", "mean", "deviation"),
                [
                    (name, f"{each['mean']:.3f}", f"{each['sd']:.3f}")
                    for name, each in zip(EVENT_NAMES, spreads.values(), strict=True)
                ],
            ),
        ),
        pictures=(
            Picture(
                "combination",
                "Figure 19",
                "From above: robot (squares) and human (circles) every 2 s; the dotted line joins "
                "them when the robot decelerates, the solid one when it stands. Below: speed, "
                "distance and position error with the human, and alone (dashed); shaded: where all "
                "noise seeds lie.",
                plots.combination(found),
            ),
        ),
    )

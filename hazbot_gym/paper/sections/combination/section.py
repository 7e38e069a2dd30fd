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
            "Figure 19 shows the combination without numbers, and the path of the human is not "
            "printed. In the scenario circle+human, a human walks beside the circle in the "
            "opposite direction at 0.5 m/s. The robot has the dynamic drive model on plant B, "
            f"with slew limits and the noise of Table 2, over {len(found.runs)} seeds. The "
            "pattern is classified as encountering. The robot decelerates on its path at "
            f"{spreads['decelerates_s']['mean']:.1f} s and stands still from "
            f"{spreads['stops_s']['mean']:.1f} s on. As the human moves away, the robot returns "
            f"to its speed, reaches it at {spreads['recovers_s']['mean']:.1f} s, and continues "
            "along the circle. While the human is within 1.5 m, the robot moves for "
            f"{spreads['moving_inside_s']['mean']:.1f} s.",
            "Slowing down and starting again increases the tracking error. From the deceleration "
            f"on, the position error reaches {met:.3f} m, compared with {met_alone:.3f} m without "
            "the human. Over the whole lap, including the start from rest, it reaches "
            f"{largest:.3f} m with the human and {largest_alone:.3f} m without (with slew limits, "
            f"the start is gentler than in section 5.2); the RMS errors are {1e3 * rms:.0f} mm "
            f"and {1e3 * rms_alone:.0f} mm. In the last {LAST_S:g} s the error is at most "
            f"{1e3 * final:.1f} mm with the human and {1e3 * final_alone:.1f} mm without: the "
            f"robot is on its circle again. The robot completes {100.0 * found.arrivals():.0f} % "
            f"of the laps, in {with_s:.1f} s with the human and {alone_s:.1f} s without.",
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
                "Top: robot (squares) and human (circles), every 2 s. The dotted line connects "
                "the two when the robot decelerates, the solid line when the robot stands still. "
                "Bottom: speed, distance, and position error with the human, and without "
                "(dashed); shaded: range over all noise seeds.",
                plots.combination(found),
            ),
        ),
    )

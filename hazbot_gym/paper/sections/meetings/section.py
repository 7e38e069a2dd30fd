"""Section 5.1: crossing and encountering, simulated and as an experiment."""

from __future__ import annotations

import math

from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.numbers import reported
from hazbot_gym.paper.sections.meetings import plots
from hazbot_gym.paper.sections.meetings.experiment import (
    EVENT_NAMES,
    Events,
    Meeting,
    events,
    falls_below_s,
    meet,
    spread,
    start_of,
)
from hazbot_gym.paper.sections.meetings.plots import MARKED_S
from hazbot_gym.paper.sections.meetings.variants import (
    BELOW,
    CHOSEN,
    REFIT,
    WALL,
    Wall,
    by_width,
    front_wall,
    jump_of_wide_terms,
)
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M

SIMULATIONS = {"crossing_sim": "C*", "encountering_sim": "E*"}
EXPERIMENTS = {"crossing_exp": "C-experiment", "encountering_exp": "E-experiment"}
FIGURES = {"crossing_sim": "Figure 13", "crossing_exp": "Figure 14",
           "encountering_sim": "Figure 15", "encountering_exp": "Figure 16"}  # fmt: skip
NOISE = {"sensors": {"tracker": {"position_noise_m": 0.03}}}  # half width of Table 2
HEAD = EVENT_NAMES[:6]


def chapter(quick: bool) -> Chapter:
    """Run the section."""
    seeds = range(20 if quick else 200)
    runs = {name: meet(scenario)[0] for name, scenario in SIMULATIONS.items()}
    found = {name: events(run) for name, run in runs.items()}
    noisy = {
        scenario: spread([events(run) for run in meet(scenario, seeds=seeds, overrides=NOISE)])
        for scenario in SIMULATIONS.values()
    }
    experiments = {name: meet(scenario, seeds=seeds) for name, scenario in EXPERIMENTS.items()}
    spreads = {
        name: spread([events(run, is_measured=True) for run in many])
        for name, many in experiments.items()
    }
    others = {name: events(meet(name)[0]) for name in ("E5.5", "C90")}
    widths, wall = by_width(), front_wall(seeds)
    return Chapter(
        number="5.1",
        title="Dynamic Obstacle Avoidance Behavior Strategy",
        here=_here(found, spreads) | {"crossing_exp_wall_s": wall.slows_s},
        record={
            "simulations": {name: each._asdict() for name, each in {**found, **others}.items()},
            "noise": noisy,
            "experiments": spreads,
            "by_width": {
                name: {scenario: events(run)._asdict() for scenario, run in each.items()}
                for name, each in widths.items()
            },
            "front_wall": wall._asdict(),
            "seeds": len(seeds),
        },
        text=_text(found, noisy, spreads, others, widths, wall, len(seeds)),
        tables=(
            _simulation_table(found, others),
            _stop_table(widths),
            _spread_table(
                f"Simulations with ±0.03 m on the distance, {len(seeds)} seeds: mean ± deviation",
                noisy,
            ),
            _spread_table(
                f"Experiments, {len(seeds)} seeds: mean ± deviation of the robot's own speed",
                {EXPERIMENTS[name]: each for name, each in spreads.items()},
            ),
        ),
        pictures=_pictures(runs, found, experiments),
    )


def _here(
    found: dict[str, Events], spreads: dict[str, dict[str, dict[str, float]]]
) -> dict[str, float]:
    here = {}
    for name, scenario in (SIMULATIONS | EXPERIMENTS).items():
        start = start_of(scenario)
        here[f"{name}_human_mps"] = start["human_mps"]
        if name in SIMULATIONS:
            here[f"{name}_robot_mps"] = start["robot_mps"]
            here[f"{name}_decelerates_s"] = found[name].decelerates_s
            here[f"{name}_stops_s"] = found[name].stops_s
        else:
            here[f"{name}_decelerates_s"] = spreads[name]["decelerates_s"]["mean"]
            here[f"{name}_stops_s"] = spreads[name]["stops_s"]["mean"]
        if name != "encountering_sim":  # without start positions in the paper
            here[f"{name}_distance_m"] = start["distance_m"]
    rounded = {name: round(value, 6) for name, value in here.items()}  # of a start given as x and y
    return rounded | {
        "sim_sampling_s": start_of("C*")["sampling_s"],
        "human_marker_s": MARKED_S,
    }


def _text(
    found: dict[str, Events],
    noisy: dict[str, dict[str, dict[str, float]]],
    spreads: dict[str, dict[str, dict[str, float]]],
    others: dict[str, Events],
    widths: dict[str, dict[str, Meeting]],
    wall: Wall,
    seeds: int,
) -> tuple[str, ...]:
    crossing, encountering = found["crossing_sim"], found["encountering_sim"]
    c_exp, e_exp = spreads["crossing_exp"], spreads["encountering_exp"]
    start = start_of("E-experiment")
    earliest_s = (start["distance_m"] - 3.0) / (start["human_mps"] + start["robot_mps"])
    star = noisy["E*"]
    return (
        "The paper does not print the start positions of its simulations. The geometries E* and "
        "C* were chosen once so that the human comes within 3.0 m when the paper says that the "
        "robot decelerates; the stop then follows. When encountering, the robot decelerates at "
        f"{encountering.decelerates_s:.1f} s and stops at {encountering.stops_s:.1f} s (paper: "
        f"1.6 and 3.4 s); when crossing, at {crossing.decelerates_s:.1f} and "
        f"{crossing.stops_s:.1f} s (paper: 4.6 and 8.6 s). With noise of ±0.03 m on the distance, "
        f"E* gives {star['decelerates_s']['mean']:.2f} ± {star['decelerates_s']['sd']:.2f} s and "
        f"{star['stops_s']['mean']:.2f} ± {star['stops_s']['sd']:.2f} s over {seeds} seeds.",
        _on_widths(widths),
        "A crossing at a right angle from 5.5 m, with both at 0.5 m/s, cannot be the paper's: in "
        f"that geometry (C90), the robot decelerates at {others['C90'].decelerates_s:.1f} s and "
        f"stops at {others['C90'].stops_s:.1f} s. In C*, the human crosses obliquely, from ahead "
        "on the left.",
        "The experiments are simulated with the dynamic drive model: wheel loops on plant B, "
        "slew limits, the noise of Table 2, and a robot that starts from rest when the human "
        "starts to walk. When crossing from 5.5 m, the robot's own speed starts to fall at "
        f"{c_exp['decelerates_s']['mean']:.1f} s, and the robot stops at "
        f"{c_exp['stops_s']['mean']:.1f} s (paper: about 5 and 9 s). As in the paper, the events "
        "of the experiment are later than those of the simulation, because of the start from "
        "rest and the lag of the drive.",
        "The paper describes the crossing experiment in two places. The second description does "
        "not mention that the robot waits for the human: at about 9 s, the robot approaches the "
        "front wall and stops. The robot can reach the wall only after it has waited. With a "
        f"wall across its path, {wall.stands_at_m:g} m from the start, and the controller's own "
        f"stop (drive.reflex_stop_m; the scenario {WALL}), the robot slows down for the wall at "
        f"{wall.slows_s:.1f} s and stops {wall.gap_m:.2f} m from it.",
        "When encountering from 5.5 m, the robot's speed starts to fall at "
        f"{e_exp['decelerates_s']['mean']:.1f} s, and the robot stops at "
        f"{e_exp['stops_s']['mean']:.1f} s (paper: about 2 and 4 s). At a closing speed of 1 m/s, "
        f"the distance cannot fall from 5.5 to 3.0 m in less than {earliest_s:.1f} s with any "
        "controller. Either the initial distance was smaller, or the experimenter was faster "
        "than the paper says.",
        f"The minimum distance in E* is {encountering.least_m:.1f} m, the lateral offset at which "
        "the human passes the standing robot. It does not indicate a failure of the strategy and "
        "is not scored. The requirement is that the robot does not move while the human is "
        "within 1.5 m, and the robot meets this requirement.",
    )


def _on_widths(widths: dict[str, dict[str, Meeting]]) -> str:
    """Describe the changes that bring all four simulated times within tolerance."""
    wide = {scenario: events(run) for scenario, run in widths[REFIT].items()}
    return (
        "The stop at 3.4 s is the only simulated time that is not reproduced. The robot's speed "
        f"falls below a tenth of nominal at {falls_below_s(widths[CHOSEN]['E*'], 0.1):.1f} s. The "
        "width of the distance terms is our choice. With all terms 0.25 m wide and a different "
        "start of the crossing, also 5.5 m away, all four times are met within 0.2 s: "
        f"{wide['E*'].decelerates_s:.1f} and {wide['E*'].stops_s:.1f} s, "
        f"{wide['C*'].decelerates_s:.1f} and {wide['C*'].stops_s:.1f} s. With these terms, "
        f"however, the speed jumps by {100.0 * jump_of_wide_terms():.0f} % at {AVOIDANCE_M:g} m, "
        "and the width would be fitted to four numbers. They are an option "
        "(fuzzy_reading:reading=width)."
    )


def _simulation_table(found: dict[str, Events], others: dict[str, Events]) -> Table:
    rows = {SIMULATIONS[name]: each for name, each in found.items()} | others
    return Table(
        "Simulations without noise",
        ("scenario", *HEAD),
        [(name, *(_shown(value) for value in each[: len(HEAD)])) for name, each in rows.items()],
    )


def _stop_table(widths: dict[str, dict[str, Meeting]]) -> Table:
    return Table(
        "When the commanded speed falls below a share of nominal [s] (paper: E* 3.4, C* 8.6)",
        ("terms of distance", *(f"{scenario}, {below}" for scenario in SIMULATIONS.values()
                                for below in BELOW)),
        [
            (terms, *(_shown(falls_below_s(run, share)) for run in runs.values()
                      for share in BELOW.values()))
            for terms, runs in widths.items()
        ],
    )  # fmt: skip


def _spread_table(caption: str, found: dict[str, dict[str, dict[str, float]]]) -> Table:
    fields = Events._fields[: len(HEAD)]
    return Table(
        caption,
        ("scenario", *HEAD),
        [
            (name, *(f"{each[field]['mean']:.2f} ± {each[field]['sd']:.2f}" for field in fields))
            for name, each in found.items()
        ],
    )


def _shown(value: float) -> str:
    return "never" if math.isnan(value) else f"{value:.2f}"


def _pictures(
    runs: dict[str, Meeting], found: dict[str, Events], experiments: dict[str, list[Meeting]]
) -> tuple[Picture, ...]:
    numbers = reported().numbers
    pictures = []
    for name, scenario in (SIMULATIONS | EXPERIMENTS).items():
        is_measured = name in EXPERIMENTS
        run = experiments[name][0] if is_measured else runs[name]
        paper = [(what, numbers[f"{name}_{what}_s"].paper) for what in ("decelerates", "stops")]
        drawn = plots.meeting(
            run,
            events(run, is_measured=True) if is_measured else found[name],
            paper,
            is_measured=is_measured,
            others=experiments[name][1:8] if is_measured else (),
        )
        kind = "experiment (here simulated, with noise)" if is_measured else "simulation"
        caption = (
            f"The {name.partition('_')[0]} {kind}, scenario {scenario}. Top: the robot (solid "
            "squares) and the human (hollow circles), every second. The dotted line connects the "
            "two when the robot decelerates, the solid line when the robot stops. Bottom: speed "
            "and distance; dashed lines are the paper's events, circles are ours."
        )
        pictures.append(Picture(f"meeting-{name.replace('_', '-')}", FIGURES[name], caption, drawn))
    return tuple(pictures)

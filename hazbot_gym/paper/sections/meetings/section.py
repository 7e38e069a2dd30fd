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
        "The paper does not print where its simulations start. The geometries E* and C* were "
        "chosen once such that the human comes within 3.0 m when the paper says "
        "that the robot decelerates; when it stops, and how, then follows. Encountering, the "
        f"robot decelerates at {encountering.decelerates_s:.1f} s and stops at "
        f"{encountering.stops_s:.1f} s (paper 1.6 and 3.4 s); crossing, at "
        f"{crossing.decelerates_s:.1f} and {crossing.stops_s:.1f} s (paper 4.6 and 8.6 s). "
        f"With noise of ±0.03 m on the distance, over {seeds} seeds, E* gives "
        f"{star['decelerates_s']['mean']:.2f} ± {star['decelerates_s']['sd']:.2f} s and "
        f"{star['stops_s']['mean']:.2f} ± {star['stops_s']['sd']:.2f} s.",
        _on_widths(widths),
        "A human who crosses at a right angle from 5.5 m, both at 0.5 m/s, cannot be the paper's: "
        f"in that geometry (C90) the robot decelerates at {others['C90'].decelerates_s:.1f} s and "
        f"stops at {others['C90'].stops_s:.1f} s. C* crosses obliquely, from ahead on the left.",
        "The experiments are run with the drive in earnest: wheel loops on plant B, slew limits, "
        "the noise of Table 2, and a robot that starts from rest when the human starts to walk. "
        f"Crossing from 5.5 m, its own speed falls at {c_exp['decelerates_s']['mean']:.1f} s and "
        f"is gone at {c_exp['stops_s']['mean']:.1f} s (paper: about 5 and 9 s). That the "
        "experiment is later than the simulation, as in the paper, comes from the start from rest "
        "and the lag of the drive.",
        "The crossing experiment is told twice. The second time the robot is not said to wait for "
        "the human: at about 9 s it comes near the front wall and stops. It can do that only after "
        "it has waited. With a wall across its way, "
        f"{wall.stands_at_m:g} m from the start, and the controller's own stop "
        f"(drive.reflex_stop_m; the scenario {WALL}) it slows down for the wall at "
        f"{wall.slows_s:.1f} s and stands {wall.gap_m:.2f} m from it.",
        f"Encountering from 5.5 m, it falls at {e_exp['decelerates_s']['mean']:.1f} s and is gone "
        f"at {e_exp['stops_s']['mean']:.1f} s (paper: about 2 and 4 s). At a closing speed of "
        f"1 m/s nobody comes from 5.5 to 3.0 m in less than {earliest_s:.1f} s, whatever the "
        "controller: either the distance was smaller or the experimenter faster than the paper "
        "says.",
        f"The least distance in E* is {encountering.least_m:.1f} m: the human passes a standing "
        "robot at that offset. It is no fault of the strategy, and no score; what counts is that "
        "the robot does not move while somebody is within 1.5 m, and it does not.",
    )


def _on_widths(widths: dict[str, dict[str, Meeting]]) -> str:
    """Describe the changes that bring all four simulated times within tolerance."""
    wide = {scenario: events(run) for scenario, run in widths[REFIT].items()}
    return (
        "The 3.4 s are the one time of the simulations that is not met. Below a tenth of its speed "
        f"the robot is at {falls_below_s(widths[CHOSEN]['E*'], 0.1):.1f} s already. And how wide "
        "the terms of the distance are is our choice: with all of them 0.25 m wide, and a crossing "
        "that starts elsewhere for them, also 5.5 m away, all four times come within 0.2 s: "
        f"{wide['E*'].decelerates_s:.1f} and {wide['E*'].stops_s:.1f} s, "
        f"{wide['C*'].decelerates_s:.1f} and {wide['C*'].stops_s:.1f} s. It costs a jump of the "
        f"speed by {100.0 * jump_of_wide_terms():.0f} % at {AVOIDANCE_M:g} m and would be a width "
        "fitted to four numbers; it is an option (fuzzy_reading:reading=width)."
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
        told = [(what, numbers[f"{name}_{what}_s"].paper) for what in ("decelerates", "stops")]
        drawn = plots.meeting(
            run,
            events(run, is_measured=True) if is_measured else found[name],
            told,
            is_measured=is_measured,
            others=experiments[name][1:8] if is_measured else (),
        )
        kind = "experiment (here simulated, with noise)" if is_measured else "simulation"
        caption = (
            f"The {name.partition('_')[0]} {kind}, scenario {scenario}. From above: the robot's "
            "solid squares and the human's hollow circles every second; the dotted line joins "
            "them when the robot decelerates, the solid one when it stops. Below: speed and "
            "distance, with the paper's events dashed and ours as circles."
        )
        pictures.append(Picture(f"meeting-{name.replace('_', '-')}", FIGURES[name], caption, drawn))
    return tuple(pictures)

"""Section 5.1: crossing and encountering, simulated and as an experiment."""

from __future__ import annotations

import math

from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.figures import meetings as figures
from hazbot_gym.paper.figures.meetings import MARKED_S
from hazbot_gym.paper.meetings import Events, Meeting, events, meet, spread, start_of
from hazbot_gym.paper.numbers import reported

SIMULATIONS = {"crossing_sim": "C*", "encountering_sim": "E*"}
EXPERIMENTS = {"crossing_exp": "C-experiment", "encountering_exp": "E-experiment"}
FIGURES = {"crossing_sim": "Figure 13", "crossing_exp": "Figure 14",
           "encountering_sim": "Figure 15", "encountering_exp": "Figure 16"}  # fmt: skip
NOISE = {"sensors": {"tracker": {"position_noise_m": 0.03}}}  # SPEC section 6
HEAD = ("decelerates [s]", "stops [s]", "recovers [s]", "least distance [m]",
        "slowest [m/s]", "moves within 1.5 m [s]")  # fmt: skip


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
    return Chapter(
        number="5.1",
        title="Dynamic Obstacle Avoidance Behavior Strategy",
        here=_here(found, spreads),
        record={
            "simulations": {name: each._asdict() for name, each in {**found, **others}.items()},
            "noise": noisy,
            "experiments": spreads,
            "seeds": len(seeds),
        },
        text=_text(found, noisy, spreads, others, len(seeds)),
        tables=(
            _simulation_table(found, others),
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
        if name != "encountering_sim":  # of which the paper does not say how it begins
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
    seeds: int,
) -> tuple[str, ...]:
    crossing, encountering = found["crossing_sim"], found["encountering_sim"]
    c_exp, e_exp = spreads["crossing_exp"], spreads["encountering_exp"]
    start = start_of("E-experiment")
    earliest_s = (start["distance_m"] - 3.0) / (start["human_mps"] + start["robot_mps"])
    star = noisy["E*"]
    return (
        "The paper does not print where its simulations start. The geometries E* and C* were "
        "chosen once (SPEC section 4) so that the human comes within 3.0 m when the paper says "
        "that the robot decelerates; when it stops, and how, then follows. Encountering, the "
        f"robot decelerates at {encountering.decelerates_s:.1f} s and stops at "
        f"{encountering.stops_s:.1f} s (paper 1.6 and 3.4 s); crossing, at "
        f"{crossing.decelerates_s:.1f} and {crossing.stops_s:.1f} s (paper 4.6 and 8.6 s). "
        f"With noise of ±0.03 m on the distance, over {seeds} seeds, E* gives "
        f"{star['decelerates_s']['mean']:.2f} ± {star['decelerates_s']['sd']:.2f} s and "
        f"{star['stops_s']['mean']:.2f} ± {star['stops_s']['sd']:.2f} s.",
        "A human who crosses at a right angle from 5.5 m, both at 0.5 m/s, cannot be the paper's: "
        f"in that geometry (C90) the robot decelerates at {others['C90'].decelerates_s:.1f} s and "
        f"stops at {others['C90'].stops_s:.1f} s. C* crosses obliquely, from ahead on the left.",
        "The experiments are run with the drive in earnest: wheel loops on plant B, slew limits, "
        "the noise of Table 2, and a robot that starts from rest when the human starts to walk. "
        f"Crossing from 5.5 m, its own speed falls at {c_exp['decelerates_s']['mean']:.1f} s and "
        f"is gone at {c_exp['stops_s']['mean']:.1f} s (paper: about 5 and 9 s). That the "
        "experiment is later than the simulation, as in the paper, comes from the start from rest "
        "and the lag of the drive.",
        f"Encountering from 5.5 m, it falls at {e_exp['decelerates_s']['mean']:.1f} s and is gone "
        f"at {e_exp['stops_s']['mean']:.1f} s (paper: about 2 and 4 s). At a closing speed of "
        f"1 m/s nobody comes from 5.5 to 3.0 m in less than {earliest_s:.1f} s, whatever the "
        "controller: either the distance was smaller or the experimenter faster than the paper "
        "says.",
        f"The least distance in E* is {encountering.least_m:.1f} m: the human passes a standing "
        "robot at that offset. It is no fault of the strategy, and no score; what counts is that "
        "the robot does not move while somebody is within 1.5 m, and it does not.",
    )


def _simulation_table(found: dict[str, Events], others: dict[str, Events]) -> Table:
    rows = {SIMULATIONS[name]: each for name, each in found.items()} | others
    return Table(
        "Simulations without noise",
        ("scenario", *HEAD),
        [(name, *(_shown(value) for value in each[: len(HEAD)])) for name, each in rows.items()],
    )


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
        drawn = figures.meeting(
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

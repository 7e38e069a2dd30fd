"""Section 3.2.1: the social force model."""

from __future__ import annotations

from hazbot_gym.core.proxemics import PHASE_BOUNDS_M
from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce
from hazbot_gym.core.state import ROBOT_MASS_KG
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.meetings.experiment import EVENT_NAMES, Events, events, meet
from hazbot_gym.paper.sections.social_force import plots
from hazbot_gym.paper.sections.social_force.experiment import drawn
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, SENSITIVE_M

SCENARIOS = ("E*", "C*")
FORCES = ("social force", "social force, four times as strong")
POLICIES = {
    "fuzzy strategy": "fuzzy_expert",
    "fuzzy strategy, eq 8b with t = 0.5 s": "fuzzy_expert:horizon_s=0.5",
    "fuzzy strategy, eq 8b with t = 1 s": "fuzzy_expert:horizon_s=1",
    FORCES[0]: "social_force",
    FORCES[1]: "social_force:strength=4",
}


def chapter(quick: bool) -> Chapter:
    """Run the section; it is the same in either form."""
    found = {
        (name, scenario): events(meet(scenario, policy)[0])
        for name, policy in POLICIES.items()
        for scenario in SCENARIOS
    }
    robot = drawn()["robot"][1]
    return Chapter(
        number="3.2.1",
        title="Social Force Model",
        here={
            "robot_mass_kg": ROBOT_MASS_KG,
            "hall_0_m": 0.0,
            **{f"hall_{k}_m": bound for k, bound in enumerate(PHASE_BOUNDS_M, start=1)},
            "avoidance_min_m": SENSITIVE_M,
            "avoidance_max_m": AVOIDANCE_M,
        },
        record={
            "policies": {
                f"{name}, {scenario}": each._asdict() for (name, scenario), each in found.items()
            },
            "forces_on_the_robot_n": {**robot._asdict(), "total": robot.total},
        },
        text=(
            "Equation 7 adds three forces. The paper gives neither force laws nor constants, so "
            "the equation cannot be checked. The forces used here are those of Helbing and "
            "Molnar (1995, Physical Review E 51, 4282). The robot uses their published "
            "constants; for people, four constants are calibrated on pedestrians recorded in "
            "corridors. docs/people.md compares the simulated people with recorded ones.",
            "Equation 8a turns the forces into a speed policy, social_force: the total force in "
            "the robot's direction of travel gives its acceleration. Helbing and Molnar's forces "
            "are per unit mass, so the robot's 34 kg cancel. In the situation of Figure 4, the "
            f"total force in that direction is {robot.total[0]:.0f} N. {_as_strategy(found)}",
            "Equation 8b subtracts v(t) t from the distance and does not define t. Read as a "
            "fixed horizon, t makes the robot react earlier. No reported event requires it, so "
            "it is off by default.",
            "Hall's distances are as in the paper, except for the last: 25 feet are 7.62 m, "
            f"which Hall gives as {PHASE_BOUNDS_M[-1]:g} m and the paper as 7.50 m. The paper's "
            "avoidance range of 1.5 to 3.0 m lies within the social distance.",
        ),
        tables=(_constants(), _policy_table(found)),
        pictures=(
            Picture(
                "social-forces",
                "Figure 4",
                "Forces on a robot at 0.35 m/s and on a curious human of 80 kg walking in the "
                "opposite direction at 0.9 m/s, with Helbing and Molnar's constants. The scale "
                "of the arrows is at the lower left.",
                plots.situation(),
            ),
            Picture(
                "social-force-repulsion",
                "",
                "Repulsion between two people as a function of their clearance, with the "
                "published and with the calibrated constants.",
                plots.repulsion(),
            ),
            Picture(
                "hall-zones",
                "",
                "Hall's four distances, each with a near and a far phase, and the paper's "
                "avoidance range.",
                plots.zones(),
            ),
        ),
    )


def _as_strategy(found: dict[tuple[str, str], Events]) -> str:
    """Describe the policy in comparison with the fuzzy strategy, which never moves within 1.5 m."""
    plain, strong = ({s: found[name, s] for s in SCENARIOS} for name in FORCES)
    return (
        "The policy responds to clearance alone and lets the robot come much closer than the "
        f"fuzzy strategy does. As published, it moves within {SENSITIVE_M:g} m of the human for "
        f"{plain['E*'].moving_inside_s:.1f} s in E* and comes within {plain['C*'].least_m:.2f} m "
        "in C*. With forces four times as strong, the minimum distance in C* is "
        f"{strong['C*'].least_m:.2f} m, but the robot still moves within {SENSITIVE_M:g} m for "
        f"{strong['E*'].moving_inside_s:.1f} s in E*: a human beside the robot pushes it neither "
        "back nor forward, so the robot sets off before the human has passed. By the criteria of "
        "section 3.2.3, this is unsafe: the social force lacks the fuzzy strategy's stop within "
        "the sensitive distance."
    )


def _constants() -> Table:
    published, ours = HELBING_MOLNAR_1995._asdict(), SocialForce()._asdict()
    return Table(
        "Constants of the social force: published, and calibrated for people",
        ("constant", "Helbing and Molnar 1995", "here"),
        [(name, published[name], ours[name]) for name in ours],
    )


def _policy_table(found: dict[tuple[str, str], Events]) -> Table:
    return Table(
        "The social force as a speed policy, and eq 8b",
        ("policy, scenario", *EVENT_NAMES[:4], EVENT_NAMES[5]),
        [
            (
                f"{name}, {scenario}",
                *(
                    "never" if value != value else f"{value:.1f}"
                    for value in (each.decelerates_s, each.stops_s, each.recovers_s)
                ),
                f"{each.least_m:.2f}",
                f"{each.moving_inside_s:.1f}",
            )
            for (name, scenario), each in found.items()
        ],
    )

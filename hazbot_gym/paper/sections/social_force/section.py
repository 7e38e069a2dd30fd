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
            "Equation 7 adds three forces; the paper gives no law for any of them and no constant, "
            "so nothing in it can be checked. Taken are the forces of Helbing and Molnar (1995, "
            "Physical Review E 51, 4282): with their published constants for the robot, and for "
            "people with four constants calibrated on pedestrians recorded in corridors. How well "
            "people then walk like recorded ones is on docs/people.md.",
            "Equation 8a makes a speed policy of it, social_force: the total force along the "
            "robot's way gives its acceleration. Helbing and Molnar's forces are per unit mass, so "
            "that the robot's 34 kg cancel; in the drawn situation its total force is "
            f"{robot.total[0]:.0f} N along its way. {_as_strategy(found)}",
            "Equation 8b takes v(t) t off the distance and does not say what t is. As a fixed "
            "horizon it makes the robot act earlier; no reported event needs it, and it is off by "
            "default.",
            "Hall's distances are as in the paper, but for the last: 25 feet are 7.62 m, which he "
            f"gives as {PHASE_BOUNDS_M[-1]:g} m and the paper as 7.50 m. The paper's avoidance "
            "range of 1.5 to 3.0 m lies within the social distance.",
        ),
        tables=(_constants(), _policy_table(found)),
        pictures=(
            Picture(
                "social-forces",
                "Figure 4",
                "Forces on a robot at 0.35 m/s and a curious human of 80 kg who comes the other "
                "way at 0.9 m/s, by Helbing and Molnar's constants; arrows are drawn to the scale "
                "below left.",
                plots.situation(),
            ),
            Picture(
                "social-force-repulsion",
                "",
                "How people who keep their distance repel each other over the clearance between "
                "them: the published law, and as calibrated.",
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
        "It answers to clearance alone, and lets the robot come much nearer than the fuzzy "
        f"strategy: as published it moves within {SENSITIVE_M:g} m of the human for "
        f"{plain['E*'].moving_inside_s:.1f} s in E* and comes to {plain['C*'].least_m:.2f} m in "
        f"C*. Four times as strong it keeps {strong['C*'].least_m:.2f} m there, and still moves "
        f"within {SENSITIVE_M:g} m for {strong['E*'].moving_inside_s:.1f} s in E*: somebody beside "
        "the robot pushes it neither back nor on, so it sets off before the human has gone by. By "
        f"the criteria of section 3.2.3 that is unsafe; what the force lacks is the fuzzy "
        "strategy's stop within the sensitive distance."
    )


def _constants() -> Table:
    published, ours = HELBING_MOLNAR_1995._asdict(), SocialForce()._asdict()
    return Table(
        "Constants of the social force: published, and of people here",
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

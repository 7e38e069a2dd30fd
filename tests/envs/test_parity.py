"""The two engines agree: the same seeds and actions lead to the same episodes.

By default a few scenarios of each environment and people model; ``HAZBOT_PARITY=200`` asks for 200
of each with every tier and driver, which takes half an hour.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.config import Config, make_config
from hazbot_gym.config.section import Section
from hazbot_gym.core.gas_sensor import GAS_SENSORS
from hazbot_gym.core.state import GAS, PRESENT, Floats, records
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert
from hazbot_gym.sim import world as world_module
from hazbot_gym.task.leak import gas_info
from hazbot_gym.task.reward import terms_of

SCENARIOS = int(os.environ.get("HAZBOT_PARITY", "0"))  # of each combination; 0: a few of some
EPISODES = 5 if SCENARIOS else 1  # one after the other in a world
WORLDS = math.ceil(SCENARIOS / EPISODES) or 2
TOLERANCE = 1e-6
SMELT = tuple(gas_info(records(GAS, 0)))  # what infos tell of gas
MODELS = ("scripted", "social_force", "replay", "seeded")
RUNS = [
    ("tracks", "random"),
    ("tracks", "expert"),
    ("privileged", "random"),
    ("privileged", "expert"),
    ("sonar", "random"),  # the expert needs to see people
]


class Passed(NamedTuple):
    """Records of all decisions, resets included; a batch has a second axis of worlds."""

    observations: npt.NDArray[np.float32]  # (T, width)
    numbers: Floats  # (T, 10 or more): reward, cost, terms, speed of a contact, and gas
    bodies: Floats  # (T, 3 + 2 P): the robot's pose and people's positions, NaN where absent
    ends: npt.NDArray[np.str_]  # (T,): how an episode ended and who caused it, else empty


# --- drivers -------------------------------------------------------------------------------------

Driver = Callable[[Any], npt.NDArray[np.float32]]  # observations (N, width) to actions (N, 1)


def driver(name: str, worlds: int, seed: int) -> Driver:
    """Return the expert, or one that arrives, touches people or runs out of time at random."""
    if name == "expert":
        expert = FuzzyExpert()
        return lambda observations: expert.predict(observations)[0]
    rng = np.random.default_rng(seed)
    bias = rng.uniform(-0.2, 1.0, (worlds, 1))
    return lambda _: np.clip(bias + rng.uniform(-1.0, 1.0, bias.shape), -1.0, 1.0).astype("f4")


def retelling(taken: npt.NDArray[np.float32]) -> Driver:
    """Return a driver that takes noted actions (T, N, 1), and then stops."""
    actions = iter(taken)
    return lambda _: next(actions, np.full_like(taken[0], -1.0))


# --- running both --------------------------------------------------------------------------------


def in_batch(
    envs: CorridorVectorEnv, act: Driver, seed: int, episodes: int = 1
) -> tuple[Passed, npt.NDArray[np.float32]]:
    """Run until every world has ended its episodes; return what passed and the actions taken."""
    observations, info = envs.reset(seed=seed)
    rewards, over = np.zeros(envs.num_envs), np.zeros(envs.num_envs, np.int64)
    rows, taken = [batch_row(envs, observations, rewards, info)], []
    while over.min() < episodes:
        taken.append(act(observations))
        observations, rewards, terminated, truncated, info = envs.step(taken[-1])
        over += terminated | truncated
        rows.append(batch_row(envs, observations, rewards, info))
    return passed(rows), np.array(taken)


def batch_row(envs: CorridorVectorEnv, observations: Any, rewards: Floats, info: Any) -> Any:
    terms = [info["reward_terms"][name] for name in terms_of(envs.config)]
    gas = [info["gas"][name] for name in SMELT] if "gas" in info else []
    numbers = np.transpose([rewards, info["cost"], *terms, info["contact_speed_mps"], *gas])
    ends = list(map(end_of, info["outcome"], info["contact_caused_by"]))
    return observations, numbers, envs._worlds.robots.copy(), envs._worlds.people.copy(), ends


def end_of(outcome: str, caused_by: str) -> str:
    return "" if outcome == "running" else f"{outcome} {caused_by}"


def alone(env: CorridorEnv, taken: Any, seed: int, episodes: int = 1) -> Passed:
    """Take the actions (T, 1) in the reference engine, resetting where the batch does."""
    return passed(list(rows_alone(env, taken, seed, episodes)))


def rows_alone(env: CorridorEnv, taken: Any, seed: int, episodes: int) -> Iterator[Any]:
    observation, info = env.reset(seed=seed)
    yield row_alone(env, observation, 0.0, info)
    is_over = False
    for action in taken:
        if is_over:
            observation, info = env.reset()
            reward, is_over = 0.0, False
        else:
            observation, reward, terminated, truncated, info = env.step(action)
            is_over = terminated or truncated
        yield row_alone(env, observation, reward, info)
        episodes -= is_over
        if episodes == 0:
            return


def row_alone(env: CorridorEnv, observation: Any, reward: Any, info: dict[str, Any]) -> Any:
    terms = info["reward_terms"].values()
    gas = [info["gas"][name] for name in SMELT] if "gas" in info else []
    numbers = [reward, info["cost"], *terms, info["contact_speed_mps"], *gas]
    end = end_of(info["outcome"], info["contact_caused_by"])
    return observation, numbers, env._world.robots[0].copy(), env._world.people.copy(), end


def passed(rows: list[Any]) -> Passed:
    """Stack rows; of the people only those present have a place."""
    *plain, robots, people, ends = zip(*rows, strict=True)
    observations, numbers, ends = map(np.array, (*plain, ends))
    robots, people = joined(robots), joined(people)
    is_absent = people["status"] != PRESENT
    xy = [np.where(is_absent, np.nan, people[axis]) for axis in ("x", "y")]
    pose = np.stack([robots["x"], robots["y"], robots["theta"]], axis=-1)
    return Passed(observations, numbers, np.concatenate([pose, *xy], axis=-1), ends)


def joined(rows: tuple[Any, ...]) -> Any:
    """Stack records; NumPy would work out the types of their fields again in each row."""
    flat = np.frombuffer(b"".join(row.tobytes() for row in rows), rows[0].dtype)
    return flat.reshape(len(rows), *rows[0].shape)


# --- comparing -----------------------------------------------------------------------------------


def gap(batch: Passed, i: int, reference: Passed) -> float:
    """Return the largest difference in world i; inf if episodes end or people enter otherwise."""
    steps = len(reference.ends)
    if len(batch.ends) < steps or (batch.ends[:steps, i] != reference.ends).any():
        return math.inf
    worst = 0.0
    for of_batch, of_reference in zip(batch[:3], reference[:3], strict=True):
        mine, other = of_batch[:steps, i].astype("f8"), of_reference.astype("f8")
        if mine.shape != other.shape or (np.isnan(mine) != np.isnan(other)).any():
            return math.inf
        worst = max(worst, float(np.nanmax(np.abs(mine - other), initial=0.0)))
    return worst


def pair(worlds: int, **arguments: Any) -> tuple[CorridorVectorEnv, CorridorEnv]:
    """Return both engines for the same problem."""
    return CorridorVectorEnv(worlds, **arguments), CorridorEnv(**arguments)


def compare(
    envs: CorridorVectorEnv, env: CorridorEnv, *, seed: int, name: str = "random", episodes: int = 1
) -> tuple[float, list[str]]:
    """Return the largest difference, and how the reference's episodes ended."""
    act = driver(name, envs.num_envs, seed)
    batch, taken = in_batch(envs, act, seed, episodes)
    references = [alone(env, taken[:, i], seed + i, episodes) for i in range(envs.num_envs)]
    ends = [end for reference in references for end in reference.ends.tolist() if end]
    return max(gap(batch, i, reference) for i, reference in enumerate(references)), ends


# --- every environment, people model, tier and driver --------------------------------------------


def combinations() -> Iterator[tuple[int, str, str, str, str]]:
    """Count up (first seed, id, model, tier, driver); by default with one run of each model."""
    for row, name in enumerate(ENVIRONMENTS):
        for column, model in enumerate(MODELS):
            for k, (tier, driver_name) in enumerate(RUNS):
                if SCENARIOS or k == (row + column) % len(RUNS):
                    yield 1000 * (len(MODELS) * row + column), name, model, tier, driver_name


@pytest.mark.parametrize(("seed", "name", "model", "tier", "driver_name"), list(combinations()))
def test_both_engines_tell_the_same_story(
    seed: int, name: str, model: str, tier: str, driver_name: str
) -> None:
    engines = pair(WORLDS, preset=ENVIRONMENTS[name][1], tier=tier, people={"model": model})
    worst, ends = compare(*engines, seed=seed, name=driver_name, episodes=EPISODES)
    print(f"{name} {model} {tier} {driver_name}: {worst:.1e}, {len(ends)} episodes")
    assert worst <= TOLERANCE
    assert len(ends) == WORLDS * EPISODES


VARIANTS: dict[str, dict[str, Any]] = {
    "slow tracker": {"sensors": {"tracker": {"latency_steps": 3, "dropout": 0.2}}},
    "noisy ears": {"sensors": {"ultrasonic": {"cross_talk": 0.2, "gaussian": True}}},
    "one sensor at a time": {"sensors": {"ultrasonic": {"sequential": True}}},
    "six sensors": {
        "tier": "sonar",
        "drive": {"reflex_stop_m": 0.5},
        "sensors": {"ring": "six", "ultrasonic": {"cross_talk": 0.2, "gaussian": True}},
    },
    "a ring of one's own, in turn": {
        "sensors": {
            "ring": [
                {"name": "ahead", "angle_rad": 0.0, "half_cone_rad": 0.5},
                {"name": "behind", "angle_rad": 3.0},
                *({"name": f"aside_{i}", "angle_rad": 0.2 + 0.2 * i} for i in range(7)),
            ],
            "ultrasonic": {"sequential": True},
        }
    },
    "seven person slots": {"person_slots": 7, "people": {"count": [8, 8]}},
    "one person slot, beside gas": {"person_slots": 1, "gas": {}},
    "fast drive": {"drive": {"nominal_speed_mps": 2.0}, "place": "circle"},
    "reflex": {"drive": {"reflex_stop_m": 1.0}, "tier": "sonar"},
    "slow drive": {"drive": {"latency_steps": 7, "start_speed_mps": 0.2}},
    "slow drive with a reflex": {"drive": {"latency_steps": 4, "reflex_stop_m": 1.0}},
    "eight lamps": {"drive": {"line_sensor": {"pitch_m": 0.015}}, "place": "circle"},
    "PID drive": {"drive": {"wheel_loop": "pid", "plant": "B", "start_speed_mps": 0.3}},
    "ideal drive": {"drive": {"wheel_loop": "ideal"}},
    "another clock": {"clock": {"physics_s": 0.005, "social_s": 0.1, "decision_s": 0.2}},
    "nobody": {"people": {"count": [0, 0]}},
    "crowd": {"people": {"count": [12, 12]}, "place": "intersection"},
    "depth": {"people": {"count": [12, 12]}, "place": "doorway", "nearness": "depth"},
    "gas in another sensor, at another clock": {
        "gas": {
            "sensor": {"rise_s": 1.0, "decay_s": 4.0, "half_ppm": 5.0, "exponent": 0.5},
            "leak_share": 1.0,
            "strength_ppm": [20.0, 20.0],
        },
        "clock": {"physics_s": 0.005, "social_s": 0.1, "decision_s": 0.2},
        "tier": "sonar",
    },
    "gas in the open": {"gas": {"leak_share": 1.0}, "place": "open"},
    "named scenario": {"scenario": "E*", "gas": {}},
    "circle and human": {"scenario": "circle+human"},
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_both_engines_agree_on_every_option(variant: str) -> None:
    worst, _ = compare(*pair(2, **VARIANTS[variant]), seed=3)
    assert worst <= TOLERANCE


def test_people_are_touched_at_the_same_moment() -> None:
    sparse = {"model": "scripted", "count": [1, 4], "mix": [0.0, 0.4, 0.3, 0.3]}
    engines = pair(25, preset=ENVIRONMENTS["Doorway-v1"][1], people=sparse)
    worst, ends = compare(*engines, seed=50)
    assert worst <= TOLERANCE
    assert {"contact_person robot", "contact_person person"} <= set(ends)
    assert sum(end.startswith("contact") for end in ends) > 15


def test_walls_are_touched_at_the_same_moment() -> None:
    drive = {"tracking": {"a2": 0.0, "a3": 0.0}, "wheel_noise_radps": 0.5}  # does not steer
    worst, ends = compare(*pair(4, place="aisle", people={"count": [0, 0]}, drive=drive), seed=7)
    assert worst <= TOLERANCE
    assert "contact_wall robot" in ends


def test_a_world_goes_through_the_scenarios_of_a_single_environment() -> None:
    """The batch draws keys 16 ahead; 40 episodes take three such draws."""
    worst, ends = compare(*pair(2, max_episode_steps=3), seed=11, episodes=40)
    assert worst <= TOLERANCE
    assert len(ends) == 80


@pytest.mark.long
@pytest.mark.parametrize("model", ["replay", "seeded"])
def test_real_tracks_are_replayed_alike(model: str, tracks_dir: Path) -> None:
    worst, _ = compare(*pair(4, tracks=str(tracks_dir), people={"model": model}), seed=1)
    assert worst <= TOLERANCE


# --- the comparison sees a change of one constant ------------------------------------------------

# A problem in which everything counts; one engine keeps to it, the other is changed.
RICH = make_config(
    place="intersection",
    people={
        "count": [3, 5],
        "reaction_shares": [0.3, 0.3, 0.2, 0.2],
        "reactions": [
            {"gain": gain, "range_m": 2.0, "attraction_mps2": 0.2} for gain in (0.5, 1.0, 1.5, 2.0)
        ],
    },
    drive={
        "plant": {"T2": 0.02, "u_max": 8.0},
        "reflex_stop_m": 0.5,
        "latency_steps": 2,
        "line_sensor": {"pitch_m": 0.015},
    },
    sensors={
        "ultrasonic": {"cross_talk": 0.1, "range_m": 3.0, "miss_angle_rad": 1.05},
        "tracker": {"dropout": 0.1, "latency_steps": 1, "moving_mps": 1.2},
    },
    gas={
        "sensor": GAS_SENSORS["TGS2611"]._asdict(),
        "leak_share": 0.6,
        "strength_ppm": [20.0, 100.0],
    },
)
HANDFUL = [
    "gas.strength_ppm.0",
    "gas.draught_mps.1",
    "gas.plume.sigma0_m",
    "gas.plume.meander_s",
    "gas.sensor.decay_s",
    "gas.sensor.false_alarms_per_h",
    "reward.survey",
    "drive.acceleration_mps2",
    "drive.plant.T1",
    "drive.tracking.a2",
    "drive.pid.kd",
    "drive.fuzzy.kp_span",
    "drive.wheel_noise_radps",
    "drive.latency_steps",
    "drive.line_sensor.pitch_m",
    "people.speeds.mean_mps",
    "people.force.relaxation_time_s",
    "people.force.robot_strength_mps2",
    "sensors.ultrasonic.noise_m",
    "sensors.tracker.position_noise_m",
    "reward.progress",
    "reward.burden",
]
# The castor moves nothing, and the periods of the clock must divide each other.
LEFT_OUT = ("drive.chassis.L1", "drive.chassis.L2", "drive.chassis.L3", "clock.")
# A hundredth of these shows in one world of many only; they are changed by half.
COARSE = ("gas.leak_share", "people.mix", "people.reaction_shares", "arrival_tolerance_m")


def parts(value: Any) -> dict[str, Any]:
    """Return the parts of which a section or tuple of the config consists of, by name."""
    if isinstance(value, Section):
        return {name: getattr(value, name) for name in type(value).model_fields}
    fields = getattr(value, "_fields", map(str, range(len(value))))
    return dict(zip(fields, value, strict=True))


def leaves(value: Any, path: str = "") -> Iterator[str]:
    """Name every number in a config."""
    if isinstance(value, Section | tuple):
        for name, below in parts(value).items():
            yield from leaves(below, f"{path}.{name}" if path else name)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path


def changed(value: Any, path: str, share: float = 0.01) -> Any:
    """Return a config with one number larger by a share of it, or by 1 if it is a count."""
    if not path:
        return value + 1 if isinstance(value, int) else (1.0 + share) * value or share
    name, _, rest = path.partition(".")
    new = {**parts(value), name: changed(parts(value)[name], rest, share)}
    if isinstance(value, Section):
        return value.model_copy(update={name: new[name]})
    return value._replace(**new) if hasattr(value, "_replace") else tuple(new.values())


class Story(NamedTuple):
    """Records of some worlds of the reference engine."""

    config: Config
    taken: npt.NDArray[np.float32]  # (T, N, 1)
    worlds: list[Passed]


def tell(worlds: int, config: Config) -> Story:
    act = driver("random", worlds, 5)
    taken = in_batch(CorridorVectorEnv(worlds, config), act, 5)[1]
    env = CorridorEnv(config)
    return Story(config, taken, [alone(env, taken[:, i], 5 + i) for i in range(worlds)])


def strays(story: Story, leaf: str, share: float = 0.01) -> float:
    """Return the deviation of the batched engine from a story if one number is changed."""
    envs = CorridorVectorEnv(len(story.worlds), changed(story.config, leaf, share))
    batch, _ = in_batch(envs, retelling(story.taken), 5)
    return max(gap(batch, i, reference) for i, reference in enumerate(story.worlds))


@pytest.fixture(scope="module")
def story() -> Story:
    return tell(4, RICH)


def test_an_unchanged_engine_does_not_stray(story: Story) -> None:
    assert strays(story, "reward.progress", share=0.0) <= TOLERANCE


@pytest.mark.parametrize("leaf", HANDFUL)
def test_a_hundredth_of_a_constant_is_noticed(leaf: str, story: Story) -> None:
    assert strays(story, leaf) > TOLERANCE


@pytest.mark.parametrize("leaf", HANDFUL[-3:])
def test_a_hundredth_in_the_reference_engine_is_noticed(leaf: str, story: Story) -> None:
    batch, _ = in_batch(CorridorVectorEnv(4, RICH), retelling(story.taken), 5)
    assert gap(batch, 0, alone(CorridorEnv(changed(RICH, leaf)), story.taken[:, 0], 5)) > TOLERANCE


@pytest.mark.long
def test_a_hundredth_of_any_constant_is_noticed() -> None:
    scripted = RICH.people.model_copy(update={"model": "scripted"})
    bumping = RICH.model_copy(update={"place": "doorway", "people": scripted})
    unnoticed = [leaf for leaf in leaves(RICH) if not leaf.startswith(LEFT_OUT)]
    for story in (tell(24, RICH), tell(24, bumping)):
        shares = {leaf: 0.5 if leaf.startswith(COARSE) else 0.01 for leaf in unnoticed}
        unnoticed = [leaf for leaf in unnoticed if strays(story, leaf, shares[leaf]) <= TOLERANCE]
    assert unnoticed == []


def test_a_wider_robot_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Finding contacts is the one thing that the engines do by different code."""
    monkeypatch.setattr(world_module, "ROBOT_RADIUS_M", 0.303)
    engines = pair(8, preset=ENVIRONMENTS["Doorway-v1"][1], people={"model": "scripted"})
    assert compare(*engines, seed=50)[0] > TOLERANCE

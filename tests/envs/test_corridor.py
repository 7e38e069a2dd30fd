from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import pytest
from gymnasium.envs.registration import EnvSpec

from hazbot_gym.config import make_config
from hazbot_gym.core.state import PATTERN_NAMES, PRESENT
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.observation import LAYOUTS, layout_for, layout_in
from hazbot_gym.task.reward import SURVEY_TERM, TERMS, terms_of, weights_of
from tests.refusals import refused, says

IDS = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
FULL, STOP = np.array([1.0]), np.array([-1.0])
TYPES_IN_INFO = {
    "scenario_key": int,
    "place": str,
    "time_free_s": float,
    "time_s": float,
    "reward_terms": dict,
    "cost": float,
    "outcome": str,
    "contact_caused_by": str,
    "contact_speed_mps": float,
}
TYPES_IN_GAS = {
    "concentration_ppm": float,
    "reading": float,
    "alarm": int,
    "leak": int,
    "leak_s_m": float,
    "leak_distance_m": float,
    "reported": int,
    "false_alarms": int,
}

everywhere = pytest.mark.parametrize("env_id", IDS)


class Step:
    """Return values of one step, by name."""

    def __init__(self, returned: tuple[Any, ...]) -> None:
        self.observation, self.reward, self.terminated, self.truncated, self.info = returned

    @property
    def is_last(self) -> bool:
        return bool(self.terminated or self.truncated)


def make(env_id: str = IDS[0], **options: Any) -> CorridorEnv:
    env = gymnasium.make(env_id, **options).unwrapped
    assert isinstance(env, CorridorEnv)
    return env


def with_walker(x: float, y: float, vx: float, vy: float = 0.0, **options: Any) -> CorridorEnv:
    """Return an environment in the open with one scripted walker, and reset it."""
    walker = {"x_m": x, "y_m": y, "vx_mps": vx, "vy_mps": vy}
    env = make(place="open", people={"model": "scripted", "walkers": [walker]}, **options)
    env.reset(seed=0)
    return env


def episode(env: CorridorEnv, action: npt.NDArray[Any] | None = None) -> Iterator[Step]:
    """Step to the end of an episode, with one action or random ones."""
    step = None
    while step is None or not step.is_last:
        step = Step(env.step(env.action_space.sample() if action is None else action))
        yield step


# --- reward and info -----------------------------------------------------------------------------


@everywhere
def test_the_reward_is_the_weighted_sum_of_terms_in_their_ranges(env_id: str) -> None:
    env = make(env_id)
    env.action_space.seed(1)
    env.reset(seed=1)
    names, weights = terms_of(env.config), weights_of(env.config)
    for _ in range(2):
        for step in episode(env):
            terms = step.info["reward_terms"]
            assert tuple(terms) == names
            assert step.reward == pytest.approx(weights @ list(terms.values()), abs=1e-12)
            most = dict.fromkeys(TERMS, 1.0) | {"burden": len(env.snapshot().people)}
            most["arrival"] = env.config.max_episode_steps * env.config.clock.decision_s
            if env.config.gas is not None:
                assert -1.0 <= terms.pop(SURVEY_TERM) <= 1.0
            assert all(0.0 <= value <= most[name] for name, value in terms.items())
            assert 0.0 <= step.info["cost"] <= 2.0
        env.reset()


@everywhere
def test_info_holds_what_the_contract_says(env_id: str) -> None:
    env = make(env_id)
    _, info = env.reset(seed=2)
    assert types_in(info) == expected_in(env)
    assert 20.0 < info["time_free_s"] < 60.0
    scenario = {name: info[name] for name in ("scenario_key", "place", "time_free_s")}
    for count, step in enumerate(episode(env, FULL), start=1):
        assert types_in(step.info) == expected_in(env)
        assert step.info.items() >= scenario.items()
        assert step.info["time_s"] == pytest.approx(0.1 * count)
        is_contact = step.info["outcome"].startswith("contact")
        assert (step.info["outcome"] == "running") == (not step.is_last)
        assert (step.info["contact_caused_by"] == "nobody") == (not is_contact)
        assert (step.info["contact_speed_mps"] == 0.0) == (not is_contact)


def types_in(info: dict[str, Any]) -> dict[str, Any]:
    """Return the types of values, within the gas as well."""
    found: dict[str, Any] = {name: type(value) for name, value in info.items()}
    if "gas" in info:
        found["gas"] = {name: type(value) for name, value in info["gas"].items()}
    return found


def expected_in(env: CorridorEnv) -> dict[str, Any]:
    return TYPES_IN_INFO if env.config.gas is None else {**TYPES_IN_INFO, "gas": TYPES_IN_GAS}


def test_a_reset_after_a_contact_tells_nothing_of_it() -> None:
    env = with_walker(2.0, 0.0, 0.0)
    assert list(episode(env, FULL))[-1].info["cost"] > 1.0
    _, info = env.reset()
    told = (info["outcome"], info["contact_caused_by"], info["contact_speed_mps"], info["cost"])
    assert told == ("running", "nobody", 0.0, 0.0)
    assert set(info["reward_terms"].values()) == {0.0}


@everywhere
def test_observations_and_infos_share_no_memory(env_id: str) -> None:
    env = make(env_id)
    first, info = env.reset(seed=3)
    observations, infos = [first], [info]
    for _ in range(5):
        step = Step(env.step(FULL))
        observations.append(step.observation)
        infos.append(step.info)
    for i, one in enumerate(observations):
        assert one.base is None
        assert not any(np.shares_memory(one, other) for other in observations[i + 1 :])
    assert len({id(info["reward_terms"]) for info in infos}) == len(infos)
    kept = [observation.copy() for observation in observations]
    observations[-1][:] = 0.0
    env.step(FULL)
    assert np.array_equal(observations[:-1], kept[:-1])


def test_the_cost_counts_only_contacts_that_the_robot_caused() -> None:
    struck = list(episode(with_walker(2.0, 0.0, 0.0), FULL))[-1]
    assert struck.info["contact_caused_by"] == "robot"
    assert struck.info["cost"] == pytest.approx(struck.info["reward_terms"]["intrusion"] + 1.0)
    hit = list(episode(with_walker(2.0, 0.0, -1.0), STOP))[-1]
    assert hit.info["contact_caused_by"] == "person"
    assert hit.info["cost"] == pytest.approx(hit.info["reward_terms"]["intrusion"])
    assert hit.info["cost"] < 0.01


# --- how episodes end ----------------------------------------------------------------------------


def test_arrival_terminates_with_what_is_left_of_the_time() -> None:
    env = make(people={"count": [0, 0]})
    _, info = env.reset(seed=0)
    steps = list(episode(env, FULL))
    last = steps[-1]
    assert (last.terminated, last.truncated, last.info["outcome"]) == (True, False, "arrived")
    assert last.info["time_s"] == pytest.approx(info["time_free_s"], abs=0.3)
    left_s = (env.config.max_episode_steps - len(steps)) * env.config.clock.decision_s
    assert last.info["reward_terms"]["arrival"] == pytest.approx(left_s)
    assert all(step.info["reward_terms"]["arrival"] == 0.0 for step in steps[:-1])
    assert env.snapshot().x == pytest.approx(12.0, abs=env.config.arrival_tolerance_m + 0.05)


def test_contact_with_a_person_terminates() -> None:
    last = list(episode(with_walker(2.0, 0.0, -1.0), FULL))[-1]
    assert (last.terminated, last.truncated) == (True, False)
    assert last.info["outcome"] == "contact_person"
    assert last.info["contact_caused_by"] == "person"
    assert last.info["contact_speed_mps"] == pytest.approx(1.4, abs=0.1)
    assert last.info["reward_terms"]["contact"] > 0.0


@pytest.mark.filterwarnings("ignore:.*may touch it:hazbot_gym.errors.DoubtfulPlace")
def test_contact_with_a_wall_terminates(tmp_path: Any) -> None:
    """A place so narrow that the robot's tracking error in its corner reaches the wall."""
    narrow = tmp_path / "narrow.yaml"
    narrow.write_text(
        "name: narrow\n"
        "path: {points: [[0, 0], [3, 0], [3, 3]], corner_radius_m: 0.5}\n"
        "walls: [[0.5, -0.305, 2.2, -0.305], [3.31, 0.6, 3.31, 2.5]]\n"
    )
    plant = {"K": 2.0, "T1": 3.0, "T2": 0.0, "Tf": 0.05, "a": -0.25}
    env = make(place=str(narrow), people={"count": [0, 0]}, drive={"plant": plant})
    env.reset(seed=0)
    last = list(episode(env, FULL))[-1]
    assert last.info["outcome"] == "contact_wall"
    assert last.info["contact_caused_by"] == "robot"
    assert 0.2 < last.info["contact_speed_mps"] < 0.8


@pytest.mark.parametrize("horizon", [1, 7, 40])
def test_time_runs_out_at_the_horizon(horizon: int) -> None:
    env = make(config={"max_episode_steps": horizon})
    env.reset(seed=0)
    steps = list(episode(env, STOP))
    assert len(steps) == horizon
    assert (steps[-1].terminated, steps[-1].truncated) == (False, True)
    assert steps[-1].info["outcome"] == "timeout"


@pytest.mark.parametrize(
    ("arguments", "horizon"),
    [
        ({}, 1200),
        ({"max_episode_steps": 7}, 7),
        ({"max_episode_steps": 700}, 700),
        ({"max_episode_steps": -1}, 1200),  # Gymnasium's word for no TimeLimit
        ({"config": {"max_episode_steps": 700}}, 700),
        ({"config": {"max_episode_steps": 9}, "max_episode_steps": 8}, 8),
        ({"config": make_config(max_episode_steps=11)}, 11),
        ({"scenario": "circle+human"}, 800),
    ],
    ids=str,
)
def test_horizon_that_make_was_asked_for_is_the_one_that_is_run(
    arguments: dict[str, Any], horizon: int
) -> None:
    first = gymnasium.make(IDS[0], **{"people": {"count": [0, 0]}, **arguments})
    assert first.spec is not None
    for env in (first, gymnasium.make(EnvSpec.from_json(first.spec.to_json()))):
        assert env.spec is not None
        assert env.spec.max_episode_steps == horizon
        env.reset(seed=0)
        steps = list(episode(env, STOP))
        assert (len(steps), steps[-1].truncated) == (horizon, True)
        assert steps[-1].info["outcome"] == "timeout"


@pytest.mark.parametrize("vector", [False, True])
@pytest.mark.parametrize(
    ("arguments", "horizon"),
    [
        ({"config": {"max_episode_steps": 20}}, None),
        ({"config": {"max_episode_steps": 50}}, None),
        ({"scenario": "circle+human"}, None),
        ({"config": {"tier": "sonar"}}, 30),
        ({"config": {"max_episode_steps": 50}, "max_episode_steps": 40}, 40),
    ],
    ids=str,
)
def test_horizon_of_an_own_spec_is_not_contradicted_silently(
    arguments: dict[str, Any], horizon: int | None, *, vector: bool
) -> None:
    registered = gymnasium.spec(IDS[0])
    spec = EnvSpec(
        "Own-v1",
        registered.entry_point,
        max_episode_steps=30,
        vector_entry_point=registered.vector_entry_point,
    )
    made = gymnasium.make_vec if vector else gymnasium.make
    if horizon is None:
        with refused("max_episode_steps ... Own-v1 ... at 30"):
            made(spec, **arguments)
        return
    env: Any = made(spec, **arguments)
    assert env.unwrapped.config.max_episode_steps == env.spec.max_episode_steps == horizon


@pytest.mark.parametrize("horizon", [0, -5, "abc", 7.5, [20], True, 10**12])
def test_horizon_that_is_none_is_refused_in_one_line(horizon: Any) -> None:
    for arguments in ({"max_episode_steps": horizon}, {"config": {"max_episode_steps": horizon}}):
        with refused("max_episode_steps"):
            gymnasium.make(IDS[0], **arguments)


def test_path_that_takes_far_longer_than_any_episode_is_refused_at_once() -> None:
    with refused("nominal_speed_mps = 1e-09"):
        CorridorEnv(drive={"nominal_speed_mps": 1e-9}).reset(seed=0)


def test_arrays_will_do_for_lists_and_are_told_as_lists() -> None:
    env: Any = gymnasium.make(IDS[0], people={"mix": np.array([1.0, 0.0, 0.0, 0.0])})
    assert env.unwrapped.config.people.mix == (1.0, 0.0, 0.0, 0.0)
    assert EnvSpec.from_json(env.spec.to_json()).kwargs["people"] == {"mix": [1.0, 0.0, 0.0, 0.0]}


def test_unknown_keyword_is_the_type_error_that_torchrl_looks_for() -> None:
    # TorchRL tries arguments, and looks for these words.
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'") as caught:
        gymnasium.make(IDS[0], frameskip=4)
    assert isinstance(caught.value, InvalidInput)
    says(str(caught.value), "frameskip ... place, ")


@pytest.mark.parametrize("key", [2**63 - 1, np.uint64(2**63 - 1), np.int64(3), 0])
def test_every_key_up_to_its_bound_is_a_scenario(key: Any) -> None:
    env = make()
    env.reset(seed=0)
    env.step(FULL)
    _, info = env.reset(options={"key": key})
    env.step(FULL)
    assert info["scenario_key"] == int(key)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"key": 2**63}, "key ... 9223372036854775808 ... integers from 0 to"),
        ({"key": -1}, "key ... -1 ... integers"),
        ({"key": True}, "key ... True ... integers"),
        ({"key": 1.0}, "key ... 1.0 ... integers"),
        ({"key": None}, "key ... None ... integers"),
        ({3: 4}, "3 ... key"),
        ({"key": 1, (1,): 4}, "(1,) ... key"),
        ([1], "[1] ... dict with key"),
        (5, "5 ... dict with key"),
    ],
    ids=str,
)
def test_reset_options_of_another_kind_are_refused(options: Any, complaint: str) -> None:
    env = make()
    with refused(f"reset options ... {complaint}"):
        env.reset(options=options)
    env.reset(seed=0)
    env.step(FULL)


@pytest.mark.parametrize("seed", [-1, True, 1.5, "x", [1]])
def test_seed_of_another_kind_is_refused(seed: Any) -> None:
    with refused("seed ... at least 0"):
        make().reset(seed=seed)


@pytest.mark.parametrize("action", [[[1], [1, 2]], [1, [2]]])
def test_ragged_actions_are_refused_in_one_line(action: Any) -> None:
    env = make()
    env.reset(seed=0)
    with refused("action"):
        env.step(action)


def test_an_episode_that_is_over_takes_no_more_steps() -> None:
    env = make()
    with refused("reset"):
        env.step(FULL)
    env.reset(seed=0)
    list(episode(env, FULL))
    with refused("reset"):
        env.step(FULL)


# --- actions -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "command_mps"), [(-1.0, 0.0), (-0.5, 0.125), (0.0, 0.25), (1.0, 0.5)]
)
def test_the_action_maps_linearly_to_the_commanded_speed(action: float, command_mps: float) -> None:
    env = make()
    env.reset(seed=0)
    env.step(np.array([action]))
    assert env.snapshot().command_mps == pytest.approx(command_mps)


@pytest.mark.parametrize("level", range(5))
def test_discrete_actions_are_the_paper_s_five_speeds(level: int) -> None:
    env = make(action_type="discrete")
    env.reset(seed=0)
    env.step(level)
    assert env.snapshot().command_mps == pytest.approx(0.125 * level)


BAD_ACTIONS = [
    ("continuous", np.array([np.nan])),
    ("continuous", np.array([np.inf])),
    ("continuous", np.array([1.01])),
    ("continuous", np.array([-1.5])),
    ("continuous", np.array([0.1, 0.2])),
    ("continuous", np.array([[0.1]])),
    ("continuous", 0.5),
    ("continuous", np.array(["fast"])),
    ("continuous", None),
    ("discrete", 5),
    ("discrete", -1),
    ("discrete", 1.5),
    ("discrete", np.array([1, 2])),
    ("discrete", "fast"),
    ("discrete", None),
]


@pytest.mark.parametrize(("kind", "action"), BAD_ACTIONS, ids=str)
def test_a_bad_action_gets_one_line_and_leaves_the_episode_as_it_was(
    kind: str, action: Any
) -> None:
    env, twin = make(action_type=kind), make(action_type=kind)
    good = env.action_space.sample()
    for each in (env, twin):
        each.reset(seed=1)
        each.step(good)
    with refused("action ... allowed"):
        env.step(action)
    assert env.step(good)[0].tolist() == twin.step(good)[0].tolist()


def test_the_reflex_stops_before_what_the_front_sensors_hear() -> None:
    env = with_walker(3.0, 0.0, 0.0, drive={"reflex_stop_m": 0.8})
    steps = [Step(env.step(FULL)) for _ in range(150)]
    assert not any(step.is_last for step in steps)
    assert env.snapshot().command_mps == 0.0
    assert 1.0 < env.snapshot().x < 2.2


def test_a_late_drive_does_the_same_later() -> None:
    drive = {"wheel_loop": "ideal", "heading_noise_rad": 0.0}
    prompt, late = (with_walker(9.0, 3.0, 0.0, drive={**drive, "latency_steps": n}) for n in (0, 6))
    speeds = np.random.default_rng(3).uniform(-1.0, 1.0, (40, 1))
    told = np.zeros((40, 2, 2))
    for k, action in enumerate(speeds):
        for i, env in enumerate((prompt, late)):
            env.step(action)
            told[k, i] = env.snapshot().command_mps, env.snapshot().speed_mps
    assert told[:, 0, 0].tolist() == told[:, 1, 0].tolist()
    assert told[:6, 1, 1].tolist() == [0.0] * 6
    assert told[6:, 1, 1] == pytest.approx(told[:-6, 0, 1], abs=1e-12)


def test_the_reflex_does_not_wait_for_a_late_command() -> None:
    """The policy's own stop comes late: at 0.5 m/s a second is half a metre."""

    def end_m(latency_steps: int, reflex_stop_m: float, stops_at_m: float) -> float:
        drive = {"reflex_stop_m": reflex_stop_m, "latency_steps": latency_steps}
        env = with_walker(4.0, 0.0, 0.0, drive=drive)
        for _ in range(120):
            env.step(FULL if env.snapshot().x < stops_at_m else STOP)
        return env.snapshot().x

    assert end_m(10, 0.8, 9.0) == pytest.approx(end_m(0, 0.8, 9.0), abs=0.05)
    assert end_m(10, 0.0, 1.5) == pytest.approx(end_m(0, 0.0, 1.5) + 0.5, abs=0.05)


# --- options of reset, snapshots, pictures -------------------------------------------------------


def test_a_snapshot_holds_the_people_present() -> None:
    env = make(people={"count": [4, 4]})
    env.reset(seed=5)
    for _ in range(10):
        env.step(FULL)
    people = env.snapshot().people
    assert np.all(people["status"] == PRESENT)
    people["x"] = 0.0
    assert not np.any(env.snapshot().people["x"] == 0.0)


def test_an_unknown_render_mode_is_refused() -> None:
    with refused("render_mode ... 'ansi' ... 'human'"):
        CorridorEnv(render_mode="ansi")


def test_without_a_render_mode_there_is_no_picture() -> None:
    env = make()
    env.reset(seed=0)
    assert env.render() is None


# --- tiers ---------------------------------------------------------------------------------------


def test_tiers_differ_in_what_they_show_of_people_and_in_nothing_else() -> None:
    widths, own, rewards = [], [], []
    for tier in ("sonar", "tracks", "privileged"):
        env = make(tier=tier)
        observation, _ = env.reset(seed=6)
        widths.append(len(observation))
        steps = [Step(env.step(FULL)) for _ in range(60)]
        own.append([step.observation[:12].tolist() for step in steps])
        rewards.append([step.reward for step in steps])
    assert widths == [12, 51, 51]
    assert own[0] == own[1] == own[2]
    assert rewards[0] == rewards[1] == rewards[2]


def test_the_privileged_tier_shows_the_true_state_whatever_the_tracker_s_faults() -> None:
    tracker = {"position_noise_m": 0.3, "dropout": 0.9, "latency_steps": 5, "range_m": 1.0}
    env = make(tier="privileged", people={"count": [3, 3]}, sensors={"tracker": tracker})
    env.reset(seed=6)
    for _ in range(30):
        observation = env.step(FULL)[0]
    state = env.snapshot()
    nearest = min(np.hypot(state.people["x"] - state.x, state.people["y"] - state.y))
    seen = LAYOUTS["privileged"].decode(observation)
    assert seen["person0_present"] == 1.0
    assert seen["person0_distance_m"] == pytest.approx(min(nearest, 8.0), abs=1e-5)


# --- variety -------------------------------------------------------------------------------------


LABELS = {f"person{i}_{pattern}" for i in range(3) for pattern in PATTERN_NAMES}


def test_no_entry_of_the_observation_is_constant() -> None:
    """Constants of an id: the curvature of a straight or circular path, and some labels of
    people, for instance crossing where no route crosses. All of these vary in another id.
    """
    varying: set[str] = set()
    for env_id in IDS:
        env = make(env_id)
        layout = layout_in(env.config)
        env.action_space.seed(0)
        rows = [env.reset(seed=0)[0]]
        while len(rows) < 3000:
            rows += [step.observation for step in episode(env)]
            rows.append(env.reset()[0])
        changes = np.ptp(rows, axis=0) > 0.0
        changing = {name for name, is_so in zip(layout.names, changes, strict=True) if is_so}
        varying |= changing
        if env.config.people.count == (0, 0):
            changing |= {name for name in layout.names if name.startswith("person")}
        # in a crowd the nearest person is always present
        assert set(layout.names) - changing <= LABELS | {"curvature_ahead_per_m", "person0_present"}
    assert varying == set(layout_for("tracks", has_gas=True).names)


class Mine(CorridorEnv):
    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)


class Holder(gymnasium.Env[Any, Any]):
    """Another environment, which holds one of this package's with a horizon of its own."""

    def __init__(self) -> None:
        self.inside = CorridorEnv(max_episode_steps=50)
        self.observation_space = self.inside.observation_space
        self.action_space = self.inside.action_space


@pytest.mark.parametrize("entry_point", [Mine, lambda **arguments: Mine(**arguments)])
def test_horizon_that_make_was_asked_for_reaches_subclasses(entry_point: Any) -> None:
    spec = EnvSpec("Mine-v1", entry_point, max_episode_steps=12)
    assert gymnasium.make(spec).unwrapped.config.max_episode_steps == 12  # type: ignore[attr-defined]


def test_horizon_of_an_environment_inside_another_is_its_own() -> None:
    spec = EnvSpec("Holder-v0", Holder, max_episode_steps=12)
    holder: Any = gymnasium.make(spec).unwrapped
    assert holder.inside.config.max_episode_steps == 50

"""Conformance with Gymnasium's vector environments, in all three autoreset modes."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import threading
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.wrappers import vector as wrappers

from hazbot_gym.config import make_config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs import vector
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.reward import terms_of, weights_of
from tests.refusals import refused

GYMNASIUM = tuple(int(part) for part in gymnasium.__version__.split(".")[:2])
IDS = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
MODES = list(AutoresetMode)
# Short episodes with contacts, arrivals and timeouts.
LIVELY: dict[str, Any] = {
    "place": "doorway",
    "place_options": {"length_m": 8.0},
    "people": {"model": "scripted", "count": [2, 4]},
    "max_episode_steps": 120,
}
# The horizon is short on purpose, so that some episodes end by it.
pytestmark = pytest.mark.filterwarnings("ignore::hazbot_gym.errors.DoubtfulPlace")
everywhere = pytest.mark.parametrize("env_id", IDS)
in_every_mode = pytest.mark.parametrize("mode", MODES)


def lively(
    worlds: int, mode: AutoresetMode = AutoresetMode.NEXT_STEP, **options: Any
) -> CorridorVectorEnv:
    return CorridorVectorEnv(worlds, autoreset_mode=mode, **LIVELY, **options)


def actions(worlds: int, steps: int, seed: int = 0) -> Floats:
    """Return fast and slow driving (T, N, 1)."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(0.0, 1.0, (worlds, 1)) + rng.uniform(-1.0, 1.0, (steps, worlds, 1))
    return np.clip(drawn, -1.0, 1.0)


def play(envs: VectorEnv[Any, Any, Any], steps: int, seed: int = 0) -> list[Any]:
    """Return results of reset and steps, episodes that are over being reset by hand if need be."""
    told: list[Any] = [envs.reset(seed=seed)]
    for action in actions(envs.num_envs, steps):
        told.append(envs.step(action))
        over = told[-1][2] | told[-1][3]
        if envs.metadata["autoreset_mode"] == AutoresetMode.DISABLED and over.any():
            told.append(envs.reset(options={"reset_mask": over}))
    return told


def same(one: Any, other: Any) -> bool:
    """Tell whether two nested results are equal bit by bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray) and one.dtype == object:
        return same(list(one), list(other))
    return bool(np.array_equal(one, other))


# --- Gymnasium's other ways to the same worlds ---------------------------------------------------


@everywhere
def test_make_vec_gives_the_same_worlds_natively_and_in_a_loop(env_id: str) -> None:
    native = gymnasium.make_vec(env_id, 2, vectorization_mode="vector_entry_point")
    loop = gymnasium.make_vec(env_id, 2, vectorization_mode="sync")
    assert isinstance(native.unwrapped, CorridorVectorEnv)
    assert native.observation_space == loop.observation_space
    assert native.action_space == loop.action_space
    assert native.single_observation_space == loop.single_observation_space
    one, other = native.reset(seed=4), loop.reset(seed=4)
    assert same(one[0], other[0])
    assert native.observation_space.contains(one[0])
    assert by_world(native, one[1]) == by_world(loop, other[1])


def by_world(envs: VectorEnv[Any, Any, Any], info: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a batch's info as one dictionary for each world, rounded, arrays as lists."""
    told: list[dict[str, Any]] = wrappers.DictInfoToList(envs)._convert_info_to_list(info)
    return [rounded(world) for world in told]


def rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: rounded(below) for name, below in value.items()}
    if isinstance(value, float | np.floating):
        return round(float(value), 9)
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


@in_every_mode
@pytest.mark.parametrize("gas", [None, {"leak_share": 0.5}], ids=["", "gas"])
def test_every_mode_does_what_gymnasiums_own_loop_does(mode: AutoresetMode, gas: Any) -> None:
    loop = SyncVectorEnv(4 * [lambda: CorridorEnv(**LIVELY, gas=gas)], autoreset_mode=mode)
    native = lively(4, mode, gas=gas)
    ours, theirs = play(native, 260), play(loop, 260)
    assert len(ours) == len(theirs)
    for (*mine, my_info), (*others, other_info) in zip(ours, theirs, strict=True):
        for one, other in zip(mine, others, strict=True):
            assert one.dtype == other.dtype
            assert one == pytest.approx(other, abs=1e-9)
        assert by_world(native, my_info) == by_world(loop, other_info)
    ends = [end for result in ours[1:] if len(result) == 5 for end in ended_with(result)]
    assert {"contact_person", "timeout"} <= set(ends)


def ended_with(result: Any) -> list[str]:
    outcomes = result[4].get("final_info", result[4])["outcome"]
    return [outcome for outcome in outcomes if outcome not in (None, "running")]


def test_a_reset_mask_leaves_the_other_worlds_alone() -> None:
    envs, plain = lively(3), lively(3)
    drive = actions(3, 20)
    for each in (envs, plain):
        each.reset(seed=1)
        for action in drive[:10]:
            each.step(action)
    mask = np.array([False, True, False])
    observations, info = envs.reset(options={"reset_mask": mask}, seed=[7, 8, 9])
    assert same(observations[1], CorridorEnv(**LIVELY).reset(seed=8)[0])
    assert info["_scenario_key"].tolist() == [False, True, False]
    for action in drive[10:]:
        one, other = envs.step(action), plain.step(action)
        assert same([part[~mask] for part in one[:4]], [part[~mask] for part in other[:4]])


def test_worlds_left_out_of_a_step_stay_as_they_are() -> None:
    envs = lively(3)
    envs.reset(seed=1)
    before = envs.step(actions(3, 1)[0])
    state = envs.state()
    mask = np.array([True, False, True])
    after = envs.step(np.ones((3, 1)), mask=mask)
    assert same([part[1] for part in before[:4]], [part[1] for part in after[:4]])
    assert envs.state().robots[1] == state.robots[1]
    assert (envs.state().time_s - state.time_s).tolist() == pytest.approx([0.1, 0.0, 0.1])


def test_a_key_asks_for_its_scenario_as_in_gymnasiums_own_loop() -> None:
    loop = SyncVectorEnv(3 * [lambda: CorridorEnv(**LIVELY)])
    native = lively(3)
    for envs in (loop, native):
        envs.reset(seed=1)
    for options in ({"key": 7}, {"key": 8, "reset_mask": np.array([True, False, True])}, None):
        (one, info), (other, told) = native.reset(options=options), loop.reset(options=options)
        assert one == pytest.approx(other, abs=1e-9)
        assert by_world(native, info) == by_world(loop, told)
    assert native.reset(options={"key": [3, None, 5]})[1]["scenario_key"][[0, 2]].tolist() == [3, 5]


def test_seeds_are_given_by_number_list_or_not_at_all() -> None:
    envs = lively(3)
    counted, _ = envs.reset(seed=5)
    listed, _ = envs.reset(seed=[5, 6, 7])
    assert same(counted, listed)
    first, _ = envs.reset()
    assert not same(first, listed)
    again, _ = envs.reset(seed=[None, 6, None])
    assert same(again[1], listed[1])
    assert not same(again[0], listed[0])
    unseeded = [lively(3).reset()[0] for _ in range(2)]
    assert not same(*unseeded)


def test_returned_arrays_are_not_touched_later() -> None:
    for mode in MODES:
        envs = lively(3, mode)
        told = play(envs, 150)
        kept = copy.deepcopy(told)
        play(envs, 10)
        assert same(told, kept)


def test_discrete_actions_command_the_five_speeds() -> None:
    envs = CorridorVectorEnv(5, action_type="discrete")
    env = CorridorEnv(action_type="discrete")
    assert envs.action_space == gymnasium.spaces.MultiDiscrete(5 * [5])
    envs.reset(seed=5 * [3])
    observations, *_ = envs.step(np.arange(5))
    for level in range(5):
        env.reset(seed=3)
        assert observations[level] == pytest.approx(env.step(level)[0], abs=1e-9)


@in_every_mode
def test_every_world_tells_the_same_keys_after_every_reset_and_step(mode: AutoresetMode) -> None:
    told = play(lively(4, mode), 150)
    names = set(CorridorEnv(**LIVELY).reset()[1])
    keys = names | {f"_{name}" for name in names}
    assert all(
        set(result[-1]) - {"final_obs", "_final_obs", "final_info", "_final_info"} == keys
        for result in told
    )


def test_the_end_of_an_episode_tells_the_scenario_that_it_had() -> None:
    envs = lively(3, AutoresetMode.SAME_STEP, gas={"leak_share": 1.0})
    _, info = envs.reset(seed=1)
    keys, leaks, ends = info["scenario_key"], info["gas"]["leak_s_m"], 0
    for action in actions(3, 300):
        *_, info = envs.step(action)
        for i in np.flatnonzero(info.get("_final_info", np.zeros(3))):
            last = info["final_info"]
            assert last["scenario_key"][i] == keys[i] != info["scenario_key"][i]
            assert last["gas"]["leak_s_m"][i] == leaks[i] != info["gas"]["leak_s_m"][i]
            ends += 1
        keys, leaks = info["scenario_key"], info["gas"]["leak_s_m"]
    assert ends > 3


def test_reward_terms_are_those_of_the_reward() -> None:
    for options in ({}, {"gas": {}}):
        envs = lively(3, **options)
        for _, rewards, *_, info in play(envs, 150)[1:]:
            terms = [info["reward_terms"][name] for name in terms_of(envs.config)]
            assert rewards == pytest.approx(weights_of(envs.config) @ np.array(terms))


# --- what make_vec passes on ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "steps"),
    [
        ({}, 1200),
        ({"max_episode_steps": 40}, 40),
        ({"max_episode_steps": 700}, 700),
        ({"config": {"max_episode_steps": 50}}, 50),
        ({"config": make_config(max_episode_steps=60)}, 60),
        ({"config": {"tier": "sonar"}}, 1200),
        ({"config": {"max_episode_steps": 1000}}, 1000),
        ({"config": {"max_episode_steps": 50}, "max_episode_steps": 60}, 60),
        ({"scenario": "circle+human"}, 800),
    ],
    ids=str,
)
def test_make_vec_keeps_the_horizon_that_was_asked_for(
    arguments: dict[str, Any], steps: int
) -> None:
    envs: Any = gymnasium.make_vec(IDS[0], 2, **arguments)
    assert type(envs) is CorridorVectorEnv
    assert envs.config.max_episode_steps == envs.spec.max_episode_steps == steps
    again: Any = gymnasium.make_vec(EnvSpec.from_json(envs.spec.to_json()))
    assert (again.num_envs, again.config) == (2, envs.config)


@pytest.mark.parametrize("horizon", [0, -5, "abc", 7.5, [20], True, 10**12])
def test_horizon_that_is_none_is_refused_in_one_line(horizon: Any) -> None:
    for arguments in ({"max_episode_steps": horizon}, {"config": {"max_episode_steps": horizon}}):
        with refused("max_episode_steps"):
            gymnasium.make_vec(IDS[0], 2, **arguments)


def test_unknown_keyword_is_a_type_error_that_names_it() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'") as caught:
        gymnasium.make_vec(IDS[0], 2, frameskip=4)
    assert isinstance(caught.value, InvalidInput)


def test_seed_of_the_last_reset_is_told() -> None:
    envs = CorridorVectorEnv(2)
    envs.reset(seed=7)
    assert envs.np_random_seed == 7
    envs.reset()
    assert envs.np_random_seed == 7
    envs.reset(seed=[3, 4])
    assert envs.np_random_seed == (3, 4)
    envs.reset(seed=[None, 5])
    assert envs.np_random_seed == (3, 5)


def test_seed_of_a_batch_that_was_given_none_repeats_its_episodes() -> None:
    envs, again = CorridorVectorEnv(2), CorridorVectorEnv(2)
    first = envs.reset()[1]["scenario_key"]
    seed: Any = envs.np_random_seed
    np.testing.assert_array_equal(again.reset(seed=seed)[1]["scenario_key"], first)


def test_generator_that_no_world_would_draw_from_is_refused() -> None:
    with refused("np_random ... Generator ... reset(seed="):
        CorridorVectorEnv(2).np_random = np.random.default_rng(0)


def test_make_vec_passes_on_mode_and_overrides() -> None:
    envs: Any = gymnasium.make_vec(
        IDS[0], 2, "vector_entry_point", autoreset_mode="SameStep", tier="sonar", threads=1
    )
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert envs.single_observation_space.shape == (12,)
    assert CorridorVectorEnv.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP


# --- Gymnasium's wrappers ------------------------------------------------------------------------


@in_every_mode
def test_episode_statistics_agree_with_our_own_counts(mode: AutoresetMode) -> None:
    if mode == AutoresetMode.SAME_STEP and GYMNASIUM < (1, 4):
        pytest.skip("RecordEpisodeStatistics leaves out a step here before Gymnasium 1.4")
    told = play(wrappers.RecordEpisodeStatistics(lively(4, mode)), 300)
    over, returns, lengths, episodes = np.zeros(4, np.bool_), np.zeros(4), np.zeros(4), 0
    for _, rewards, terminated, truncated, info in (each for each in told if len(each) == 5):
        counts = ~over if mode == AutoresetMode.NEXT_STEP else np.ones(4, np.bool_)
        returns, lengths = returns + rewards * counts, lengths + counts
        over = terminated | truncated
        last = info.get("final_info", info)
        for i in np.flatnonzero(over):
            assert info["episode"]["r"][i] == pytest.approx(returns[i])
            assert info["episode"]["l"][i] == lengths[i]
            assert last["time_s"][i] == pytest.approx(0.1 * lengths[i])
            episodes += 1
        returns[over], lengths[over] = 0.0, 0
    assert episodes > 8


# Gymnasium works the bounds out in float64 and warns that they are stored as float32.
rescaling = pytest.mark.filterwarnings("ignore:.*precision lowered by casting to float32")


@rescaling
@pytest.mark.parametrize(
    "wrap",
    [
        wrappers.NormalizeObservation,
        wrappers.NormalizeReward,
        wrappers.ClipAction,
        wrappers.DictInfoToList,
        wrappers.FlattenObservation,
        lambda envs: wrappers.RescaleAction(envs, 0.0, 1.0),
        lambda envs: wrappers.RescaleObservation(envs, -1.0, 1.0),
        lambda envs: wrappers.TransformReward(envs, np.sign),
    ],
)
def test_gymnasiums_vector_wrappers_run(wrap: Callable[[Any], VectorEnv[Any, Any, Any]]) -> None:
    envs = wrap(lively(3))
    envs.reset(seed=0)
    for _ in range(130):
        observations, rewards, *_ = envs.step(envs.action_space.sample())
    if GYMNASIUM >= (1, 3):  # before, NormalizeObservation keeps the bounds of what it normalizes
        assert envs.observation_space.contains(observations.astype(envs.observation_space.dtype))
    assert np.isfinite(rewards).all()


@rescaling
def test_rescaled_actions_are_shares_of_the_nominal_speed() -> None:
    envs = wrappers.RescaleAction(lively(2), 0.0, 1.0)
    envs.reset(seed=0)
    envs.step(np.array([[0.25], [1.0]]))
    assert envs.unwrapped.state().robots["command"] == pytest.approx([0.125, 0.5])


# --- same seeds, same results --------------------------------------------------------------------


def test_kernels_are_compiled_where_an_interrupt_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    ran_in, run_worlds = [], vector.run_worlds

    def run(*arguments: Any) -> None:
        ran_in.append(threading.current_thread() is threading.main_thread())
        run_worlds(*arguments)

    monkeypatch.setattr(vector, "run_worlds", run)
    worlds = 2 * vector.SMALLEST_BLOCK
    envs = CorridorVectorEnv(worlds, threads=2, **LIVELY)
    envs.reset(seed=0)
    assert ran_in == [True, True]
    envs.step(np.zeros((worlds, 1)))
    assert sorted(ran_in[2:]) == [False, True]
    envs.close()


@pytest.mark.parametrize("tracks", ["social_force", "replay"])
def test_threads_change_nothing(tracks: str) -> None:
    one, two = (
        CorridorVectorEnv(200, threads=threads, people={"model": tracks}, max_episode_steps=60)
        for threads in (1, 2)
    )
    assert same(play(one, 150, seed=3), play(two, 150, seed=3))
    assert len(two._blocks) == 2


def test_a_world_is_the_same_alone_and_among_a_thousand() -> None:
    drive = actions(1024, 150)
    crowd = CorridorVectorEnv(1024, max_episode_steps=100)
    told = [crowd.reset(seed=0), *(crowd.step(action) for action in drive)]
    for i in (0, 31, 32, 700, 1023):
        alone = CorridorVectorEnv(1, max_episode_steps=100)
        mine = [alone.reset(seed=i), *(alone.step(action[[i]]) for action in drive)]
        for one, among in zip(mine, told, strict=True):
            assert same([part[0] for part in one[:-1]], [part[i] for part in among[:-1]])


@pytest.mark.parametrize(
    "twin", [copy.deepcopy, lambda envs: pickle.loads(pickle.dumps(envs))], ids=["copy", "pickle"]
)
def test_a_copy_made_in_mid_episode_goes_on_alike(twin: Callable[[Any], Any]) -> None:
    envs = CorridorVectorEnv(70, threads=2, **LIVELY)
    play(envs, 30)
    other = twin(envs)
    rest = actions(70, 200, seed=1)
    assert same([envs.step(action) for action in rest], [other.step(action) for action in rest])


@pytest.mark.filterwarnings("ignore:.*use of fork.*:DeprecationWarning")  # Python 3.12 and newer
def test_a_forked_child_goes_on_like_its_parent() -> None:
    envs = CorridorVectorEnv(70, threads=2, **LIVELY)
    play(envs, 30)
    action = actions(70, 1, seed=1)[0]
    context = multiprocessing.get_context("fork")
    results = context.SimpleQueue()

    def step_and_close() -> None:
        results.put(envs.step(action)[0])
        envs.close()

    child = context.Process(target=step_and_close)
    child.start()
    child.join(timeout=60.0)
    has_hung = child.is_alive()
    child.kill()
    assert not has_hung
    assert child.exitcode == 0
    assert same(results.get(), envs.step(action)[0])


def test_closing_twice_does_no_harm() -> None:
    envs = CorridorVectorEnv(100, threads=2)
    play(envs, 2)
    envs.close()
    envs.close()
    assert envs.closed

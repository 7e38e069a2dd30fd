"""Training runs of every algorithm with tiny budgets: files, seeds, resuming, refusals."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from hazbot_gym import evaluate, policies
from hazbot_gym.policies.base import Permissions
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.training import callbacks, checkpoints
from hazbot_gym.training.config import STUDENTS, TrainConfig, load_training
from hazbot_gym.training.run import Result, train
from hazbot_gym.training.validation import validate
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

CONFIGS = Path(__file__).parents[2] / "configs"
OWN = Permissions(allow_code=True)
SHORT = {"max_episode_steps": 20}
ON_POLICY: dict[str, Any] = {"n_steps": 16, "batch_size": 32, "n_epochs": 1}
OFF_POLICY: dict[str, Any] = {
    "batch_size": 16,
    "learning_starts": 50,
    "buffer_size": 200,
    "gradient_steps": 1,
}
TINY: dict[str, Any] = {
    "worlds": 4,
    "steps": 384,
    "validation": {"every_steps": 100, "episodes": 2},
}
# The options of ppo.yaml that do not go with everything else.
PLAIN: dict[str, Any] = {
    "staggered_starts": False,
    "action_repeat": 1,
    "shaping": "none",
    "asymmetric_critic": False,
}


def tiny(name: str = "ppo", **changes: Any) -> TrainConfig:
    """Return the run of a config file, as small as it gets."""
    config = load_training(CONFIGS / f"{name}.yaml")
    small = ON_POLICY if "ppo" in name else OFF_POLICY
    if config.algorithm in STUDENTS:
        small = {}
    values = {
        **TINY,
        "overrides": {**config.overrides, **SHORT},
        "options": {**config.options, **small},
        "network": {**config.network, "net_arch": [4]},
    }
    if name == "ppo":
        values |= PLAIN
    if config.imitation:
        values["imitation"] = {"decisions": 96, "epochs": 1, "batch_size": 32}
    if len(config.env) > 1:
        values["env"] = "hazbot_gym/Corridor-v1"
    return load_training(CONFIGS / f"{name}.yaml", **{**values, **changes})


def weights(result: Result) -> dict[str, Any]:
    return {name: value.numpy() for name, value in result.model.policy.state_dict().items()}


def are_equal(one: Result, other: Result) -> bool:
    pairs = zip(weights(one).values(), weights(other).values(), strict=True)
    return all(np.array_equal(mine, others) for mine, others in pairs)


ALL = [
    "ppo",
    "ppo_from_rules",
    "ppo_sonar",
    "ppo_residual",
    "ppo_lagrangian",
    "recurrent_ppo",
    "sac",
    "td3",
    "tqc",
    "crossq",
    "dqn",
    "qrdqn",
    "bc",
    "dagger",
]


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Path, Result]]:
    """Return a function that trains a config file's run once, and gives its folder and result."""

    @functools.cache
    def run(name: str) -> tuple[Path, Result]:
        folder = tmp_path_factory.mktemp(name)
        return folder, train(tiny(name), folder)

    return run


@pytest.mark.parametrize("name", ALL)
def test_every_config_trains_and_leaves_a_policy_that_drives(
    name: str, trained: Callable[[str], tuple[Path, Result]]
) -> None:
    folder, result = trained(name)
    policy = policies.make(f"learned:{result.policy}")
    width = result.model.observation_space.shape[0] - tiny(name).asymmetric_critic
    actions, _ = policy.predict(np.zeros((3, width), np.float32))
    assert actions.shape == (3, 1)
    assert {path.name for path in folder.iterdir()} >= {
        "manifest.json",
        "result.json",
        "checkpoints",
        "tensorboard",
    }


@pytest.mark.parametrize("name", ALL)
def test_an_interrupted_run_ends_with_the_weights_of_one_that_was_not(
    name: str,
    trained: Callable[[str], tuple[Path, Result]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, unbroken = trained(name)
    calls: list[Any] = []

    def interrupt(*arguments: Any) -> Any:
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return validate(*arguments)

    monkeypatch.setattr(callbacks, "validate", interrupt)
    with pytest.raises(KeyboardInterrupt):
        train(tiny(name), tmp_path / "broken")
    told = io.StringIO()
    resumed = train(tiny(name), tmp_path / "broken", resume=True, console=Console(file=told))
    assert "the run goes on from step 1" in told.getvalue()
    found = read_json(tmp_path / "broken" / "result.json")
    assert len(calls) == len(found["validations"]) + 1 > 3
    assert are_equal(resumed, unbroken)
    assert resumed.best == unbroken.best


def test_equal_seeds_give_equal_weights_and_others_do_not(tmp_path: Path) -> None:
    one, same, other = (
        train(tiny(seed=seed), tmp_path / name) for name, seed in (("a", 3), ("b", 3), ("c", 4))
    )
    assert are_equal(one, same)
    assert not are_equal(one, other)


def test_a_finished_run_is_not_trained_again(tmp_path: Path) -> None:
    first = train(tiny(), tmp_path)
    written = (tmp_path / "policy.npz").read_bytes()
    again = train(tiny(), tmp_path, resume=True)
    assert are_equal(again, first)
    assert again.best == first.best
    assert (tmp_path / "policy.npz").read_bytes() == written


@pytest.mark.filterwarnings("ignore:.*no robot arrives:hazbot_gym.errors.DoubtfulPlace")
def test_an_edited_place_or_teacher_is_noticed_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    place, teacher = tmp_path / "lab.yaml", tmp_path / "teacher_under_test.py"
    place.write_text("{name: lab, walls: [[0, 2, 9, 2]], path: {points: [[0, 0], [9, 0]]}}")
    teacher.write_text("from hazbot_gym.policies.constant import Constant as Mine\n")
    run = tiny(
        "bc",
        overrides={**SHORT, "place": str(place)},
        imitation={"decisions": 96, "epochs": 1, "teacher": f"{teacher.stem}:Mine"},
    )
    train(run, tmp_path / "run", allowed=OWN)
    for path in (place, teacher):
        text = path.read_text()
        path.write_text(text + "# edited\n")
        with refused(f"begun with another ... {path.name}"):
            train(run, tmp_path / "run", resume=True, allowed=OWN)
        path.write_text(text)
    train(run, tmp_path / "run", resume=True, allowed=OWN)


@pytest.mark.filterwarnings("ignore:.*no robot arrives:hazbot_gym.errors.DoubtfulPlace")
def test_a_place_that_is_edited_during_a_run_ends_it_before_a_policy_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "lab.yaml"
    text = "{name: lab, walls: [[0, 2, 9, 2]], path: {points: [[0, 0], [9, 0]]}}"
    place.write_text(text)
    run = tiny(overrides={**SHORT, "place": str(place)})

    def edited(policy: Any, config: TrainConfig) -> Any:
        place.write_text(text.replace("[9, 0]", "[8, 0]"))
        return validate(policy, config)

    with monkeypatch.context() as context:
        context.setattr(callbacks, "validate", edited)
        with refused("lab.yaml' was edited"):
            train(run, tmp_path / "run")
    assert not (tmp_path / "run" / "policy.npz").exists()
    place.write_text(text)
    train(run, tmp_path / "run", resume=True)


def test_a_damaged_result_is_written_again(tmp_path: Path) -> None:
    train(tiny(), tmp_path)
    written = (tmp_path / "result.json").read_bytes()
    (tmp_path / "result.json").write_bytes(written.replace(b"return", b"retury", 1))
    train(tiny(), tmp_path, resume=True)
    assert (tmp_path / "result.json").read_bytes() == written


def test_a_damaged_checkpoint_is_passed_over_and_said_so(tmp_path: Path) -> None:
    first = train(tiny(), tmp_path)
    newest = max((tmp_path / "checkpoints").iterdir())
    newest.write_bytes(newest.read_bytes()[:-100])
    told = io.StringIO()
    again = train(tiny(), tmp_path, resume=True, console=Console(file=told, width=200))
    assert f"checkpoint {newest.name} is damaged, the one before it is used" in told.getvalue()
    assert are_equal(again, first)


def test_the_best_model_on_validation_is_the_one_that_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    returns = iter([1.0, 3.0, 2.0, 2.5])
    monkeypatch.setattr(callbacks, "validate", lambda *_: {"return": next(returns)})
    result = train(tiny(), tmp_path)
    found = read_json(tmp_path / "result.json")
    assert [each["return"] for each in found["validations"]] == [1.0, 3.0, 2.0, 2.5]
    assert result.best["return"] == found["best"]["return"] == 3.0
    about = policies.make(f"learned:{result.policy}")._policy.about  # type: ignore[attr-defined]
    assert about["results"] == {"return": 3.0, "step": found["validations"][1]["step"]}
    assert about["training"] == read_json(tmp_path / "manifest.json")


@pytest.mark.slow
def test_the_pymunk_engine_trains_too(tmp_path: Path) -> None:
    result = train(tiny(engine="pymunk", worlds=2, steps=64), tmp_path)
    assert result.model.num_timesteps == 64


@pytest.mark.parametrize("name", ["ppo_residual", "dagger"])
def test_other_observations_are_trained_on_and_driven_with(name: str, tmp_path: Path) -> None:
    ring = [{"name": f"s{i}", "angle_rad": 0.3 * i} for i in range(3)]
    overrides = {**SHORT, "person_slots": 5, "sensors": {"ring": ring}}
    result = train(tiny(name, overrides=overrides), tmp_path / name)
    spec, env = f"learned:path={result.policy}", "hazbot_gym/Corridor-v1"

    assert len(evaluate(spec, env, episodes=2, overrides=overrides)) == 2
    with refused("sensors.ring ... 4 ... 3"):
        evaluate(spec, env, episodes=2, overrides={"person_slots": 5})


def test_several_environments_are_trained_on_side_by_side(tmp_path: Path) -> None:
    env = ["hazbot_gym/Corridor-v1", "hazbot_gym/Doorway-v1"]
    best = train(tiny(env=env), tmp_path).best
    corridor, doorway = best["return/Corridor-v1"], best["return/Doorway-v1"]
    assert corridor != doorway
    assert best["return"] == pytest.approx((corridor + doorway) / 2)  # type: ignore[operator]


def curves_of(run: Path) -> EventAccumulator:
    return EventAccumulator(str(run / "tensorboard")).Reload()


def test_tensorboard_has_terms_outcomes_validation_and_the_usual_curves(tmp_path: Path) -> None:
    train(tiny(), tmp_path)
    curves = curves_of(tmp_path)
    assert {
        "episode/return",
        "episode/time_ratio",
        "episode/mean_speed_mps",
        "episode/cost",
        "reward_terms/intrusion",
        "outcome/arrived",
        "validation/return",
        "train/loss",
        "rollout/ep_rew_mean",
        "rollout/ep_len_mean",
        "time/fps",
    } <= set(curves.Tags()["scalars"])
    last = {name: curves.Scalars(name)[-1].value for name in ("episode/length", "episode/return")}
    assert curves.Scalars("rollout/ep_len_mean")[-1].value == last["episode/length"] == 20.0
    assert curves.Scalars("rollout/ep_rew_mean")[-1].value == pytest.approx(last["episode/return"])
    assert curves.Scalars("time/fps")[-1].value > 0


def test_validations_are_drawn_at_once_at_the_step_that_they_were_made_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save, drawn = checkpoints.save, []

    def look_and_save(folder: Path, model: Any, progress: Any) -> None:
        points = curves_of(tmp_path).Scalars("validation/return")
        drawn.append([(point.step, point.value) for point in points])
        save(folder, model, progress)

    monkeypatch.setattr(checkpoints, "save", look_and_save)
    train(tiny(), tmp_path)
    found = read_json(tmp_path / "result.json")["validations"]
    told = [(each["step"], pytest.approx(each["return"], rel=1e-6)) for each in found]
    assert drawn == [told[:count] for count in range(1, len(told) + 1)]


@pytest.mark.parametrize("left", [None, 0, -9])
def test_a_policy_that_was_removed_or_damaged_is_written_again_from_the_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, left: int | None
) -> None:
    returns = iter([1.0, 2.0, 3.0, 4.0])
    monkeypatch.setattr(callbacks, "validate", lambda *_: {"return": next(returns)})
    train(tiny(), tmp_path)
    result, policy = (tmp_path / name for name in ("result.json", "policy.npz"))
    before = read_json(result)
    written = policies.make(f"learned:{policy}")._policy.about  # type: ignore[attr-defined]
    policy.unlink(), result.unlink()
    if left is not None:
        policy.write_bytes(b"half a policy"[:left])
    told = io.StringIO()
    again = train(tiny(), tmp_path, resume=True, console=Console(file=told, width=200))
    assert "policy.npz was missing or damaged and is written again" in told.getvalue()
    healed = policies.make(f"learned:{again.policy}")._policy.about  # type: ignore[attr-defined]
    assert healed["results"] == written["results"] == {"return": 4.0, "step": 384}
    assert read_json(result) == before


def test_a_policy_that_was_removed_and_cannot_be_written_again_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    returns = iter([4.0, 3.0, 2.0, 1.0])
    monkeypatch.setattr(callbacks, "validate", lambda *_: {"return": next(returns)})
    train(tiny(), tmp_path)
    (tmp_path / "policy.npz").unlink()
    with refused("out: policy.npz ... damaged ... (step 1"):
        train(tiny(), tmp_path, resume=True)


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("ppo", {"options": {"n_stepz": 3}}, "options.n_stepz: unknown key ... batch_size"),
        ("ppo", {"options": {"batch_size": 1}}, "options: ppo ... `batch_size`"),
        (
            "ppo",
            {"worlds": 1000, "options": {"n_steps": 100_000}},
            "options.n_steps: 100,000,000 decisions of 1000 worlds",
        ),
        ("ppo", {"network": {"activation": "elu"}}, "network.activation: given 'elu' ... tanh"),
        ("ppo", {"algorithm": "dqn", "options": {}, "network": {}}, "options: dqn ... Discrete"),
        ("ppo", {"env": "CartPole-v1"}, "CartPole-v1"),
        ("ppo", {"overrides": {"tier": "radar"}}, "radar"),
        ("ppo", {"env": ["hazbot_gym/Corridor-v1"] * 5}, "worlds: given 4, allowed is 5"),
        ("ppo", {"residual": {"base": "nobody"}}, "residual.base: given 'nobody' ... constant"),
        ("ppo", {"residual": {"base": "ttc:horizon=3"}}, "horizon"),
        (
            "ppo",
            {"residual": {"base": "ssm"}, "overrides": {"action_type": "discrete"}},
            "residual: given action_type 'discrete'",
        ),
        ("ppo", {"imitation": {"teacher": "nobody"}}, "policy: 'nobody'"),
        (
            "ppo",
            {"imitation": {}, "overrides": {"action_type": "discrete"}},
            "imitation: given action_type 'discrete'",
        ),
        ("dagger", {"options": {"beta": 2.0}}, "options.beta: given 2.0, allowed is 0 to 1"),
        ("bc", {"options": {"beta": 0.5}}, "options: bc ... 'beta'"),
        ("dagger", {"options": {"n_steps": 5}}, "options.n_steps: unknown key ... beta"),
        ("dagger", {"imitation": {"teacher": "nobody"}}, "policy: 'nobody'"),
        ("dagger", {"imitation": {"teacher": "my_own:Teacher"}}, "'my_own:Teacher' ... code"),
        ("dagger", {"imitation": {"teacher": "learned:e.zip"}}, "--allow-pickle"),
        (
            "dagger",
            {"imitation": {"teacher": f"learned:{SHIPPED / 'ppo_sonar.npz'}"}},
            "tier: given",
        ),
        (
            "dagger",
            {"overrides": {"action_type": "discrete"}},
            "imitation: given action_type 'discrete'",
        ),
    ],
)
def test_what_cannot_be_trained_is_one_line_and_writes_nothing(
    name: str, changes: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with refused(said):
        train(tiny(name, **changes), tmp_path / "run")
    assert not (tmp_path / "run").exists()

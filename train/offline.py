"""Offline training from a Minari data set: behaviour cloning, or TD3+BC of d3rlpy.

``hazbot dataset`` writes such data sets. The result is exported like any other trained policy, and
compared with the policy of the data set on scenarios that are not in it.
"""

import argparse
from importlib.util import find_spec
from pathlib import Path

import minari
import numpy as np
import torch
from stable_baselines3 import PPO

from hazbot_gym import evaluate, means
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe
from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.policies.layer import Layer
from hazbot_gym.training.config import Imitation
from hazbot_gym.training.export import export_actor
from hazbot_gym.training.imitation import Demonstrations, learn
from hazbot_gym.utils.files import write_json


def count(text: str) -> int:
    """Read a whole number of at least 1."""
    if not text.isdecimal() or not int(text):
        raise argparse.ArgumentTypeError(f"given {text!r}, allowed are integers of at least 1")
    return int(text)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("dataset", type=Path, help="folder that hazbot dataset has written")
parser.add_argument("--method", choices=["bc", "td3_bc"], default="bc")
parser.add_argument("--epochs", type=count, default=15, help="of bc")
parser.add_argument("--updates", type=count, default=20_000, help="of td3_bc")
parser.add_argument("--episodes", type=count, default=100, help="of the comparison")
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=Path, default=Path("results/offline/policy.npz"))
parser.add_argument("--json", type=Path, help="also write the comparison to this file")
arguments = parser.parse_args()
if arguments.out.exists() or arguments.out.suffix != ".npz":  # before hours of training
    parser.error(f"--out: given {arguments.out}, allowed is a new file that ends in .npz")
if arguments.method == "td3_bc" and find_spec("d3rlpy") is None:
    parser.error("--method td3_bc: d3rlpy is not installed; docs/datasets.md says how")

HIDDEN = [96, 96]  # units of the hidden layers
torch.set_num_threads(1)  # the networks are too small to share among cores

try:
    dataset = minari.MinariDataset(str(arguments.dataset / "data"))
except ValueError as error:
    parser.error(f"dataset: given {arguments.dataset}, no folder of hazbot dataset ({error})")
env = dataset.recover_environment()
episodes = list(dataset)
observations = np.concatenate([episode.observations[:-1] for episode in episodes])
actions, rewards, terminations, truncations = (
    np.concatenate([getattr(episode, name) for episode in episodes])
    for name in ("actions", "rewards", "terminations", "truncations")
)


def behaviour_cloning() -> Actor:
    """Fit an actor to the recorded actions by least squares."""
    network = {"net_arch": HIDDEN, "activation_fn": torch.nn.ReLU}
    model = PPO("MlpPolicy", env, policy_kwargs=network, seed=arguments.seed, device="cpu")
    demonstrations = Demonstrations(torch.as_tensor(observations), torch.as_tensor(actions))
    settings = Imitation(epochs=arguments.epochs, batch_size=min(256, len(actions)))
    learn(model.policy, demonstrations, settings, torch.Generator().manual_seed(arguments.seed))
    return actor_of(model)


def td3_bc() -> Actor:
    """Maximize a learned value near the recorded actions (Fujimoto and Gu 2021)."""
    import d3rlpy

    d3rlpy.seed(arguments.seed)
    recorded = d3rlpy.dataset.MDPDataset(
        observations, actions, rewards, terminations, truncations,
        action_space=d3rlpy.ActionSpace.CONTINUOUS,
    )  # fmt: skip
    network = d3rlpy.models.VectorEncoderFactory(hidden_units=HIDDEN)
    config = d3rlpy.algos.TD3PlusBCConfig(
        gamma=0.998,
        # Without a shift: it would change what an episode is worth that a contact ends early.
        reward_scaler=d3rlpy.preprocessing.MultiplyRewardScaler(1.0 / float(rewards.std())),
        actor_encoder_factory=network,
        critic_encoder_factory=network,
    )
    algorithm = config.create(device="cpu")
    algorithm.fit(
        recorded,
        n_steps=arguments.updates,
        n_steps_per_epoch=arguments.updates,
        logger_adapter=d3rlpy.logging.NoopAdapterFactory(),
        show_progress=False,
    )
    linear = [m for m in algorithm.impl.policy.modules() if isinstance(m, torch.nn.Linear)]
    layers = [(m.weight.detach().numpy().T.copy(), m.bias.detach().numpy().copy()) for m in linear]
    return Actor(tuple(Layer(*each) for each in layers), activation="relu", head="squashed")


actor = behaviour_cloning() if arguments.method == "bc" else td3_bc()
about = {"script": "offline.py", "dataset": dataset.id, "seed": arguments.seed}
tier = env.unwrapped.config.tier
export_actor(describe(actor, algorithm=arguments.method, tier=tier, training=about), arguments.out)
teacher = dataset.storage.metadata["algorithm_name"]
changes = {**env.spec.kwargs, "max_episode_steps": env.spec.max_episode_steps}
changes.pop("preset", None)
compared = {}
for name, policy in (("recorded", teacher), ("trained", f"learned:{arguments.out}")):
    rows = evaluate(
        policy, env.spec.id, episodes=arguments.episodes, seed=10_000, overrides=changes
    )
    compared[name] = means(rows)
    print(f"{name}: return {compared[name]['return']:.1f}, {policy}")
if arguments.json:
    about |= {"method": arguments.method, "decisions": len(actions), "policy": teacher}
    write_json(arguments.json, {**about, **compared})

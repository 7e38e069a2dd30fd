"""PPO of RLlib on the batched engine: training in Ray's workers, and the export of its policy.

Needs `pip install 'ray[rllib]' torch`. RLlib asks for Gymnasium 1.2, which this library supports.
"""

import argparse
from pathlib import Path

import numpy as np
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

from hazbot_gym import evaluate, means
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe
from hazbot_gym.policies.layer import Layer
from hazbot_gym.training.export import export_actor

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--env", default="hazbot_gym/Corridor-v1")
parser.add_argument("--cluster", default="local", help="address of a Ray cluster, or auto")
parser.add_argument("--decisions", type=int, default=1_000_000)
parser.add_argument("--runners", type=int, default=1, help="worker processes, one core each")
parser.add_argument("--worlds", type=int, default=256, help="of each runner")
parser.add_argument("--horizon", type=int, default=128, help="decisions of a world in a batch")
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--episodes", type=int, default=100)
parser.add_argument("--out", type=Path, default=Path("results/rllib_ppo/policy.npz"))
arguments = parser.parse_args()

ray.init(address=arguments.cluster, log_to_driver=False)
batch = arguments.runners * arguments.worlds * arguments.horizon
config = (
    PPOConfig()
    # The module's name before the colon is imported in each runner, which registers the ids.
    .environment(f"hazbot_gym:{arguments.env}")
    .env_runners(
        num_env_runners=arguments.runners,
        num_envs_per_env_runner=arguments.worlds,
        gym_env_vectorize_mode="vector_entry_point",
        rollout_fragment_length=arguments.horizon,
        sample_timeout_s=600.0,  # the first sample may compile kernels, for a minute or more
    )
    .training(
        lr=3e-4,
        gamma=0.99,
        lambda_=0.95,
        train_batch_size_per_learner=batch,
        minibatch_size=min(batch, 4096),
        num_epochs=5,
        vf_loss_coeff=0.5,
        grad_clip=0.5,
    )
    .rl_module(
        model_config=DefaultModelConfig(
            fcnet_hiddens=[64, 64], fcnet_activation="tanh", vf_share_layers=False
        )
    )
    .debugging(seed=arguments.seed)
)
algorithm = config.build_algo()
decisions = 0
while decisions < arguments.decisions:
    result = algorithm.train()["env_runners"]
    decisions = int(result["num_env_steps_sampled_lifetime"])
    print(f"{decisions:,} decisions, return {result.get('episode_return_mean', np.nan):.1f}")

# An actor is a chain of linear layers; of the two outputs the first is the mean of the action.
state = algorithm.get_module().get_state()
layers = []
for name in [key.removesuffix(".weight") for key in state if key.endswith(".weight")]:
    if name.startswith(("encoder.actor_encoder", "pi.")):
        layers.append(Layer(state[f"{name}.weight"].T.copy(), state[f"{name}.bias"].copy()))
last = layers.pop()
layers.append(Layer(last.weight[:, :1], last.bias[:1]))
actor = Actor(tuple(layers), activation="tanh", head="clipped")
training = {"script": "rllib_ppo.py", "seed": arguments.seed, "decisions": decisions}
export_actor(
    describe(actor, algorithm="PPO of RLlib", tier="tracks", training=training), arguments.out
)
algorithm.stop()

found = means(evaluate(f"learned:{arguments.out}", arguments.env, episodes=arguments.episodes))
print(f"saved to {arguments.out}, return {found['return']:.1f}")
print(f"hazbot eval --policy learned:{arguments.out} --env {arguments.env}")

"""An algorithm of one's own: the cross-entropy method on the batched engine, without torch.

Each generation draws actors around a mean, lets every one drive in worlds of its own, and moves the
mean to the best of them (Rubinstein 1999). The result is exported like any other trained policy.
"""

import argparse
from pathlib import Path

import gymnasium
import numpy as np

import hazbot_gym  # noqa: F401  (registers the environments)
from hazbot_gym import evaluate, means
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe
from hazbot_gym.policies.layer import Layer
from hazbot_gym.training.export import export_actor

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--generations", type=int, default=30)
parser.add_argument("--actors", type=int, default=64)
parser.add_argument("--worlds-each", type=int, default=8)
parser.add_argument("--decisions", type=int, default=600)
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--out", type=Path, default=Path("results/own_algorithm/policy.npz"))
arguments = parser.parse_args()

shape = (arguments.actors, arguments.worlds_each)
envs = gymnasium.make_vec(
    "hazbot_gym/Corridor-v1",
    num_envs=arguments.actors * arguments.worlds_each,
    vectorization_mode="vector_entry_point",
)
width = envs.single_observation_space.shape[0]
rng = np.random.default_rng(arguments.seed)
mean, deviation = np.zeros(width + 1), np.ones(width + 1)  # a linear actor: weights and bias

for generation in range(arguments.generations):
    drawn = rng.normal(mean, deviation, (arguments.actors, width + 1))
    observations, _ = envs.reset(seed=arguments.seed + generation)
    returns = np.zeros(shape)
    for _ in range(arguments.decisions):
        seen = observations.reshape(*shape, width)
        actions = np.einsum("awo,ao->aw", seen, drawn[:, :-1]) + drawn[:, -1:]
        observations, rewards, *_ = envs.step(np.clip(actions, -1, 1).reshape(-1, 1))
        returns += rewards.reshape(shape)
    best = drawn[np.argsort(returns.mean(axis=1))[-arguments.actors // 5 :]]
    mean, deviation = best.mean(axis=0), best.std(axis=0) + 0.02
    print(
        f"generation {generation}: {returns.mean():.1f} a world, best {returns.mean(1).max():.1f}"
    )

layer = Layer(mean[:-1, None].astype(np.float32), mean[-1:].astype(np.float32))
actor = Actor((layer,), activation="tanh", head="clipped")
training = {"script": "own_algorithm.py", "seed": arguments.seed}
export_actor(
    describe(actor, algorithm="cross-entropy method", tier="tracks", training=training),
    arguments.out,
)
found = means(evaluate(f"learned:{arguments.out}", "hazbot_gym/Corridor-v1", episodes=20))
print(f"saved to {arguments.out}, return {found['return']:.1f}")

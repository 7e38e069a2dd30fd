"""Train with a reward term and pedestrians of one's own, and compare with the fuzzy expert."""

import argparse
from pathlib import Path

from hazbot_gym import evaluate, load_training, means, pedestrian_model, reward_term, train
from hazbot_gym.core.geometry import norm

ROOT, ENV = Path(__file__).parents[1], "hazbot_gym/Crossing-v1"
parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--config", type=Path, default=ROOT / "configs/ppo.yaml")
parser.add_argument("--episodes", type=int, default=100)
parser.add_argument("--out", type=Path, default=Path("results/own_reward_and_people"))
arguments = parser.parse_args()


@reward_term(low=0.0, high=1.0)
def crowding(robot, people, record, rules):
    """Speed among people: 1 with three of them within 2 m, at nominal speed."""
    near = 0
    for person in people:
        if person.status == 1 and norm(person.x - robot.x, person.y - robot.y) < 2.0:
            near += 1
    return min(near / 3.0, 1.0) * min(abs(robot.v) / rules.nominal_speed_mps, 1.0)


@pedestrian_model
def hesitant(me, situation):
    """Walk to the target ahead, and slowly within sight of the robot."""
    speed, robot = me.desired_speed, situation.robot
    if norm(robot.x - me.x, robot.y - me.y) < situation.reaction.range_m:
        speed *= 0.3
    return speed * situation.ahead_x, speed * situation.ahead_y


own = {"own_terms": {"crowding": -0.2}, "people": {"model": "hesitant"}}
config = load_training(arguments.config, env=ENV, overrides=own)
result = train(config, arguments.out, resume=True)
for policy in (f"learned:{result.policy}", "fuzzy_expert"):
    rows = evaluate(policy, ENV, episodes=arguments.episodes, overrides=own)
    crowding_s = sum(row["reward_crowding"] for row in rows) / len(rows) * 0.1
    print(f"{policy}: return {means(rows)['return']:.1f}, crowding {crowding_s:.2f} s an episode")

"""Compare one policy at five prices of nearness with rules: ``python docs/make_prices_record.py``.

Writes ``benchmarks/prices.json`` and ``docs/images/prices.svg``. A quarter of an hour on one core.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.prices import at_price
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.paper.plot_style import BLUE, GREEN, INK, PURPLE, RED, legend, new, svg
from hazbot_gym.policies.actor_file import read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.policies.sweeps import sweep
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json, write_text
from hazbot_gym.utils.json_object import JsonObject

ROOT = Path(__file__).parents[1]
RECORD, FRONT = ROOT / "benchmarks" / "prices.json", ROOT / "docs" / "images" / "prices.svg"
POLICY, PRICES = "ppo_prices", (1.0, 2.0, 4.0, 8.0, 16.0)
RULES = ("idm", "velocity_obstacle", "mpc")
EPISODES, SEED = 60, 21  # of each environment; no training, validation or tuning has this seed
METRICS = ("delay_s", "discomfort_s", "personal_m", "arrived", "contacts_per_km")
HUES = dict(zip(RULES, (RED, GREEN, PURPLE), strict=True))


def record() -> JsonObject:
    """Return the record of the shipped policy, the rules, and the policy without prices."""
    about = read(SHIPPED / "prices_tracks.npz").about["training"]
    environments = about["config"]["env"]
    specs = [f"{POLICY}:price={price:g}" for price in PRICES]
    return {
        "commit": provenance.commit(),
        "versions": provenance.versions(),
        "machine": provenance.machine(),
        "environments": environments,
        "episodes": EPISODES,
        "seed": SEED,
        "training": {name: about["config"][name] for name in ("steps", "action_repeat", "seed")},
        "prices": [
            {"price": price, **point(spec, environments)}
            for price, spec in zip(PRICES, specs, strict=True)
        ],
        "rules": {rule: [point(spec, environments) for spec in sweep(rule)[::2]] for rule in RULES},
        "ppo": point("ppo", environments),
    }


def point(spec: str, environments: list[str]) -> JsonObject:
    """Return the means of a policy over all environments, and its return at each price."""
    rows = [
        row for env in environments for row in evaluate(spec, env, episodes=EPISODES, seed=SEED)
    ]
    found = means(rows)
    returns = {f"{price:g}": at_price(found, price) for price in PRICES}
    return {"policy": spec, **{name: found[name] for name in METRICS}, "returns": returns}


def front(record: JsonObject) -> str:
    """Draw delay against discomfort: a line for the policy at its prices, one for each rule."""
    figure, axes = new(3.6)
    for rule, points in record["rules"].items():
        axes.plot(*_line(points), ".-", color=HUES[rule], linewidth=1.0, label=f"{rule}, swept")
    own = record["prices"]
    axes.plot(*_line(own), "o-", color=BLUE, label=f"{POLICY}, one network")
    for each in own:
        where = (each["discomfort_s"], each["delay_s"])
        axes.annotate(f"{each['price']:g}", where, xytext=(4, 4), textcoords="offset points")
    axes.plot(*_line([record["ppo"]]), "*", color=INK, label="ppo, shipped")
    axes.set_xlabel("discomfort of people, s an episode")
    axes.set_ylabel("delay, s an episode")
    axes.set_xlim(0.0, 1.15 * max(each["discomfort_s"] for each in (*own, record["ppo"])))
    axes.set_ylim(0.0, 1.5 * max(each["delay_s"] for each in own))
    legend(axes)
    return svg(figure)


def _line(points: list[JsonObject]) -> Iterator[list[float]]:
    for name in ("discomfort_s", "delay_s"):
        yield [each[name] for each in points]


if __name__ == "__main__":
    found = record()
    write_text(FRONT, front(found))
    write_json(RECORD, found)

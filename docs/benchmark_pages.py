"""The pages on performance, headroom and people, from their committed records."""

from __future__ import annotations

from string import Template

from table_text import markdown_table as table

from hazbot_gym.bench import export as exports
from hazbot_gym.bench import latency
from hazbot_gym.bench import report as bench
from hazbot_gym.bench.cases import CORRIDOR, batched
from hazbot_gym.calibration import discomfort_report, encounters_report
from hazbot_gym.calibration import report as calibration
from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M
from hazbot_gym.evaluation.oracle import headroom_report as headroom
from hazbot_gym.evaluation.oracle.headroom import EXPERT_AT_MOST, GAS_EXPERT_AT_MOST, RULE_AT_MOST
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, shown

Record = JsonObject

EXACT = "benchmarks/headroom_exact.json"  # headroom with scripted people
DEPTH = "benchmarks/headroom_depth.json"  # the same with the reward of the first version
HOOKS = ("engine", "hooks", "speed relative to none, median (quartiles)", "the same bits")
POWER = 0.20  # least share of contacts at full speed


def performance(
    template: str, record: Record, *, name: str, hooks: Record, training: Record
) -> str:
    """Return the page on performance: a template with its placeholders filled in.

    Args:
        template: With ``$`` placeholders.
        record: Of ``hazbot bench --json``.
        name: Of its file, from the root of the repository.
        hooks: Of ``make_hooks_record.py``.
        training: Of ``hazbot bench --training configs/ppo.yaml --json``.
    """
    (learned,) = training["runs"].values()
    return Template(template).substitute(
        record["machine"],
        record=name,
        what=record["what"],
        turns=record["turns"],
        rates=table(bench.RATES, bench.rate_rows(record)),
        goals=table(bench.GOALS, bench.goal_rows(record)),
        parts=table(bench.PARTS, bench.part_rows(record)),
        once=table(bench.ONCE, bench.once_rows(record)),
        hooks=table(HOOKS, hook_rows(hooks)),
        hooks_turns=hooks["turns"],
        hooks_decisions=hooks["decisions"],
        training=table(bench.GOALS, bench.goal_rows(learned)),
        training_processor=training["machine"]["processor"],
        training_seeds=len(learned["runs"]),
        training_actions=shown(learned["speed"]["batched"] / learned["config"]["action_repeat"]),
        training_repeat=learned["config"]["action_repeat"],
        training_cartpole=shown(learned["speed"]["cartpole"]),
    )


def hook_rows(record: Record) -> Rows:
    """Return engine, hooks, speed relative to none with quartiles, and whether bits are equal."""
    rows: Rows = []
    for each in record["rows"]:
        low, high = (f"{end:.3f}" for end in each["to_no_hooks_quartiles"])
        ratio = f"{each['to_no_hooks']:.3f} ({low} to {high})"
        equal = "yes" if each["is_equal"] else "no"
        rows.append((each["engine"], each["hooks"], ratio, equal))
    return rows


def readme_speed(record: Record) -> str:
    """Return the speeds that the README names."""
    machine, batch = record["machine"], record["cases"][batched(1024, 4)]
    rate, ratio = bench.rate(record[CORRIDOR])
    many, times = bench.rate(batch)
    return (
        f"{rate.partition(' (')[0]} steps a second in one environment ({ratio} of CartPole-v1's in "
        f"the same run), {many.partition(' (')[0]} in\na batch of 1024 with four people each "
        f"({times} times one CartPole-v1), on {machine['cores']} cores of {machine['processor']}."
    )


def robot(template: str, record: Record, *, name: str) -> str:
    """Return the page on robots; arguments as for ``performance``."""
    return Template(template).substitute(
        record["machine"],
        record=name,
        load=shown(record["load_before"]),
        steps=f"{record['steps']:,}",
        people=record["people"],
        latency=table(latency.TITLES, latency.rows(record)),
    )


def export(template: str, record: Record, *, name: str) -> str:
    """Return the page on exports; arguments as for ``performance``."""
    return Template(template).substitute(
        record,
        record=name,
        emulator=record["emulator"].partition(" (")[0].replace("emulator version ", ""),
        equality=table(exports.EQUAL, exports.equality_rows(record)),
        sizes=table(exports.SIZES, exports.size_rows(record)),
    )


def people(template: str, record: Record, *, name: str) -> str:
    """Return the page on the pedestrian model; arguments as for ``performance``."""
    judged = [run for run in record["runs"] if not run["fitted_on"]]
    reached, missed = (
        [run["run"] for run in judged if calibration.is_near(run, record) == near]
        for near in (True, False)
    )
    return Template(template).substitute(
        record=name,
        count={4: "Four", 5: "Five"}[len(record["fitted"])],
        goal=shown(record["goal_mps"]),
        densest=shown(record["densest_per_m2"]),
        reached=_names(reached),
        missed=_names(missed),
        constants=table(calibration.CONSTANTS, calibration.constant_rows(record)),
        losses=table(calibration.LOSSES, calibration.loss_rows(record)),
        speeds=table(calibration.SPEEDS, calibration.speed_rows(record)),
        distances=table(calibration.DISTANCES, calibration.distance_rows(record)),
        percentiles=table(calibration.PERCENTILES, calibration.percentile_rows(record)),
    )


def discomfort(template: str, record: Record, *, name: str) -> str:
    """Return the page on rated discomfort; arguments as for ``performance``."""
    at = {row["clearance_m"]: row for row in record["bounds"]}
    near, far = at[INTIMATE_M], at[PERSONAL_M]
    parts = (
        ("constants", discomfort_report.CURVE, discomfort_report.curve_rows),
        ("errors", discomfort_report.ERRORS, discomfort_report.error_rows),
        ("bounds", discomfort_report.BOUNDS, discomfort_report.bound_rows),
        ("bins", discomfort_report.BINS, discomfort_report.bin_rows),
    )
    return Template(template).substitute(
        {part: table(titles, rows(record)) for part, titles, rows in parts},
        record=name,
        ratings=f"{record['ratings']:,}",
        raters=record["raters"],
        draws=record["draws"],
        others=shown(record["others"]),
        near_front=shown(near["front"]["value"]),
        near_behind=shown(near["behind"]["value"]),
        far_front=shown(far["front"]["value"]),
        far_behind=shown(far["behind"]["value"]),
    )


def encounters(template: str, record: Record, *, name: str) -> str:
    """Return the page on people's response to the robot; arguments as for ``performance``."""
    goal, held_out = record["goal"], [row for row in record["groups"] if not row["fitted_on"]]
    is_near = [row["largest_difference_m"] <= goal for row in held_out]
    is_slowed = [(row["slowest_difference"] or 0.0) <= goal for row in held_out]
    sides = {side: {**record, "groups": _on(record, side=side)} for side in (True, False)}
    return Template(template).substitute(
        record=name,
        goal=shown(goal),
        fitted=record["encounters"]["fitted on"],
        held_out=record["encounters"]["held out"],
        groups=len(held_out),
        near=sum(is_near),
        slowed=sum(is_slowed),
        both=sum(map(min, is_near, is_slowed)),
        constants=table(encounters_report.CONSTANTS, encounters_report.constant_rows(record)),
        losses=table(encounters_report.LOSSES, encounters_report.loss_rows(record)),
        fitted_groups=table(encounters_report.GROUPS, encounters_report.group_rows(sides[True])),
        other_groups=table(encounters_report.GROUPS, encounters_report.group_rows(sides[False])),
        verdicts=table(encounters_report.VERDICTS, encounters_report.verdict_rows(record)),
        drives=record["price"]["drives"],
        prices=table(encounters_report.PRICES, encounters_report.price_rows(record)),
        drive_means=table(encounters_report.DRIVES, encounters_report.drive_rows(record)),
    )


def _on(record: Record, *, side: bool) -> list[Record]:
    return [row for row in record["groups"] if row["fitted_on"] == side]


def headroom_by_environment(
    template: str, record: Record, *, name: str, exact: Record, depth: Record
) -> str:
    """Return the page on headroom; arguments as for ``performance``.

    Args:
        template: With ``$`` placeholders.
        record: Of ``hazbot headroom --json``.
        name: Of its file, from the root of the repository.
        exact: Of ``hazbot headroom --scripted --json``.
        depth: The same with the reward of the first version.
    """
    found = record["environments"]
    wide = [env for env in found if headroom.has_room(found[env])]
    return Template(template).substitute(
        record=name,
        exact_record=EXACT,
        depth_record=DEPTH,
        episodes=record["episodes"],
        tuning=record["tuning"],
        rounds=record["search"]["rounds"],
        worlds=record["search"]["worlds"],
        expert_at_most=headroom.percent(EXPERT_AT_MOST),
        rule_at_most=headroom.percent(RULE_AT_MOST),
        wide=_names(wide),
        narrow=_names([env for env in found if env not in wide]),
        powerless=_names([env for env in found if found[env]["full_speed_contacts"] < POWER]),
        rooms=table(headroom.ROOM, headroom.room_rows(record)),
        units=table(headroom.UNITS, headroom.unit_rows(record)),
        rules=table(headroom.RULES, headroom.rule_rows(record)),
        speeds=table(headroom.SPEEDS, headroom.speed_rows(record)),
        exact_episodes=exact["episodes"],
        exact_speeds=table(("environment, reward", *headroom.SPEEDS[1:]), _both(depth, exact)),
    )


def gas(template: str, record: Record, *, name: str) -> str:
    """Return the page on gas; arguments as for ``performance``."""
    empty = record["environments"]["InspectionEmpty-v1"]
    steady = max(empty["constants"], key=lambda row: row["return"])
    rules = [row["return"] for row in empty["rules"].values()]
    return Template(template).substitute(
        record=name,
        episodes=record["episodes"],
        tuning=record["tuning"],
        rounds=record["search"]["rounds"],
        expert_at_most=headroom.percent(GAS_EXPERT_AT_MOST),
        rule_at_most=headroom.percent(RULE_AT_MOST),
        steady=steady["policy"],
        beaten=sum(each < steady["return"] for each in rules),
        rules=len(rules),
        wide=_names(
            [env for env, each in record["environments"].items() if headroom.has_room(each)]
        ),
        policies=table(headroom.SURVEY, headroom.survey_rows(record)),
    )


def _both(depth: Record, exact: Record) -> Rows:
    """Return the speeds of the optimum under both rewards."""
    return [
        (f"`{env}`, {reward}", *map(headroom.percent, record["environments"][env]["speeds"]))
        for env in exact["environments"]
        for reward, record in (("depth x v", depth), ("discomfort x v²", exact))
    ]


def _names(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"

"""C99 of a policy: a header, a source, golden vectors and a test, from the templates."""

from __future__ import annotations

import math
from importlib import resources
from typing import Any

import numpy as np

from hazbot_gym.core.fuzzy import NO_RULE_WEIGHT
from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.errors import MissingExtra
from hazbot_gym.export.golden import TOLERANCE, Golden
from hazbot_gym.export.plan import Plan, Rule
from hazbot_gym.policies import sonar_estimate as sonar
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.constant import Constant
from hazbot_gym.policies.fuzzy_expert import PERSON_FIELDS, SENSITIVE_M, FuzzyExpert
from hazbot_gym.policies.guard import ROUNDING
from hazbot_gym.policies.people_rule import with_slots
from hazbot_gym.policies.people_seen import RADII_M
from hazbot_gym.policies.person_columns import columns_of
from hazbot_gym.policies.robot import DECISION_S
from hazbot_gym.policies.ssm import Ssm
from hazbot_gym.task.observation import SONAR_RANGE_M
from hazbot_gym.utils.json_object import JsonObject

try:
    import jinja2
except ImportError as error:
    raise MissingExtra("jinja2", "export") from error

FILES = ("hazbot_policy.h", "hazbot_policy.c", "hazbot_golden.h", "hazbot_test.c")


def c_files(plan: Plan, golden: Golden, version: str) -> dict[str, str]:
    """Return the text of the C files of a plan, by name.

    Args:
        plan: The policy.
        golden: Golden vectors.
        version: Of this package, for the header.
    """
    environment, values = _environment(), _values(plan, golden, version)
    return {name: environment.get_template(name).render(values) for name in FILES}


def _environment() -> jinja2.Environment:
    folder = resources.files("hazbot_gym.export") / "templates"
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (folder / name).read_text(encoding="utf-8")),
        autoescape=False,  # it writes C, no HTML
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"single": single, "double": double}
    return environment


def single(value: float) -> str:
    """Return a float of C with the same bits as the nearest float32."""
    return f"{_literal(f'{float(np.float32(value)):.9g}')}f"


def double(value: float) -> str:
    """Return a double of C with the same bits."""
    return _literal(repr(float(value)))


def _literal(digits: str) -> str:
    return digits if "." in digits or "e" in digits else f"{digits}.0"


def _values(plan: Plan, golden: Golden, version: str) -> JsonObject:
    layout, fields = plan.layout, plan.layout.fields
    rule = None if plan.rule is None else _rule(plan.rule, plan)
    actor = None if plan.actor is None else _actor(plan.actor)
    return {
        "spec": plan.spec.replace("*/", "* /"),
        "version": version,
        "fields": fields,
        "entry": "char" if len(fields) <= 256 else "short",  # of C, for an index of an entry
        "low": [field.low for field in fields],
        "high": [field.high for field in fields],
        "scales": [field.scale for field in fields],
        "valid_low": (layout.low - np.float32(ROUNDING)).tolist(),
        "valid_high": (layout.high + np.float32(ROUNDING)).tolist(),
        "nominal_mps": plan.nominal_mps,
        "period_s": plan.period_s,
        "memory": plan.memory,
        "has_memory": plan.has_memory,
        "sonar": _sonar(plan) if plan.listens else None,
        "actor": actor,
        "rule": rule,
        "correction": plan.scale,
        "has_float_exp": plan.actor is not None and _has_tanh(plan.actor),
        "has_double_exp": isinstance(plan.rule, FuzzyExpert),
        "observations": golden.observations.tolist(),
        "starts": golden.starts.tolist(),
        "actions": golden.actions.tolist(),
        "tolerance": TOLERANCE,
    }


def _has_tanh(actor: Actor) -> bool:
    hidden = actor.activation == "tanh" and len(actor.layers) > 1
    return hidden or actor.lstm is not None or actor.head == "squashed"


def _actor(actor: Actor) -> JsonObject:
    """Return a network as lists."""
    layers = [
        {
            "inputs": len(layer.weight),
            "outputs": layer.bias.size,
            "weight": layer.weight.ravel().tolist(),
            "bias": layer.bias.tolist(),
        }
        for layer in actor.layers
    ]
    found: JsonObject = {
        "layers": layers,
        "activation": actor.activation,
        "head": actor.head,
        "normalisation": actor.normalisation is not None,
    }
    if actor.normalisation is not None:
        mean, variance, clip, epsilon = actor.normalisation
        deviation = np.sqrt(variance + np.float32(epsilon))
        found |= {"mean": mean.tolist(), "deviation": deviation.tolist(), "clip": clip}
    if actor.lstm is not None:
        weight, bias = actor.lstm.gates
        found |= {"gate_weight": weight.ravel().tolist(), "gate_bias": bias.tolist()}
    return found


def _rule(rule: Rule, plan: Plan) -> JsonObject:
    if isinstance(rule, Constant):
        return {"kind": "constant", "fraction": rule.fraction}
    return _ssm(rule, plan) if isinstance(rule, Ssm) else _fuzzy(rule, plan)


def _sonar(plan: Plan) -> JsonObject:
    """Return the estimate of people from echoes as numbers (``policies/sonar_estimate.py``)."""
    layout, people = plan.layout, with_slots(plan.layout)
    at = sonar.mounted(layout.sensors)
    entries = columns_of(people, PERSON_FIELDS)
    scales = dict(zip(PERSON_FIELDS, entries.units[0].tolist(), strict=True))
    numbers = (
        np.sin(at.angle_rad), np.cos(at.angle_rad), at.side, at.near_m, at.edge_rad,
        at.wall_offset_m,
    )  # fmt: skip
    flags = at.wall, at.in_front.astype(int), at.at_side.astype(int)

    def own(name: str) -> tuple[int, float]:
        index = layout.names.index(name)
        return index, layout.fields[index].scale

    return {
        "sensors": [
            {
                "numbers": [float(each[i]) for each in numbers],
                "flags": [int(each[i]) for each in flags],
            }
            for i in range(len(layout.sensors))
        ],
        "walls": at.walls.tolist(),
        "width": people.width,
        "slots": entries.entries.tolist(),
        "distance_scale": scales["distance_m"],
        "walking_scale": scales["speed_mps"],
        "closing_scale": scales["closing_mps"],
        "speed": own("speed_mps"),
        "yaw_rate": own("yaw_rate_radps"),
        "heading": own("theta_e_rad"),
        "range_scale": layout.fields[0].scale,
        "period_s": DECISION_S,
        "alpha": sonar.ALPHA,
        "beta_per_s": sonar.BETA / DECISION_S,
        "leap_m": sonar.LEAP_M,
        "moving_mps": sonar.MOVING_MPS,
        "settled": sonar.SETTLED,
        "wall_m": sonar.WALL_M,
        "near_m": sonar.NEAR_M,
        "steady_s": sonar.STEADY_S,
        "side_wall_m": sonar.SIDE_WALL_M,
        "carried_s": sonar.CARRIED_S,
        "same_m": sonar.SAME_M,
        "turning_radps": sonar.TURNING_RADPS,
        "to_centre_m": sonar.TO_CENTRE_M,
        "mount_m": sonar.SENSOR.mount_radius_m,
        "nothing_m": SONAR_RANGE_M - 0.1,
        "quarter_rad": math.pi / 2.0,
    }


def _ssm(rule: Ssm, plan: Plan) -> JsonObject:
    ssm, columns = SsmThresholds(), columns_of(with_slots(plan.layout), ("present", "distance_m"))
    b = ssm.braking_mps2 * ssm.reaction_s + ssm.approach_mps
    return {
        "kind": "ssm",
        "entries": columns.entries.tolist(),
        "distance_scale": columns.units[0, 1],
        "radii_m": RADII_M,
        "margin_m": rule.margin_m,
        "nominal_mps": rule.nominal_mps,
        "reach_m": ssm.approach_mps * ssm.reaction_s,
        "intrusion_m": ssm.intrusion_m,
        "uncertainty_m": ssm.uncertainty_m,
        "approach_mps": ssm.approach_mps,
        "b": b,
        "b_squared": b**2,
        "twice_braking": 2.0 * ssm.braking_mps2,
    }


def _fuzzy(rule: FuzzyExpert, plan: Plan) -> JsonObject:
    controller, columns = rule.controller, columns_of(with_slots(plan.layout), PERSON_FIELDS)

    def terms(rows: Any) -> list[list[float]]:
        return [[0.0 if math.isinf(value) else value for value in row] for row in rows.tolist()]

    return {
        "kind": "fuzzy",
        "distance": terms(controller.distance),
        "speed": terms(controller.speed),
        "rules": controller.rules[:, :3].astype(int).tolist(),
        "kept": controller.rules[:, 3].tolist(),
        "pattern_width": controller.pattern_width,
        "is_product": controller.is_product,
        "sensitive_m": controller.sensitive_m,
        "avoidance_m": controller.avoidance_m,
        "no_rule_weight": NO_RULE_WEIGHT,
        "entries": columns.entries.tolist(),
        "units": columns.units[0].tolist(),
        "patterns": len(PATTERN_NAMES),
        "release": rule.release,
        "released_m": SENSITIVE_M,
        "scale": rule.scale,
        "horizon_s": rule.horizon_s,
        "own_speed": int(columns.own[0]),
        "own_speed_scale": columns.own_units[0],
    }

"""ONNX graph of a trained policy: guard, normalisation, LSTM, layers, head and base rule.

Inputs are ``observation`` (N, width) and, with an LSTM, ``hidden`` and ``cell`` (N, size), zeros at
the start of a round. Outputs are ``action`` (N, 1) and the next ``hidden`` and ``cell``.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.export.golden import as_json, golden_of
from hazbot_gym.export.plan import Plan
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.constant import Constant
from hazbot_gym.policies.guard import ROUNDING
from hazbot_gym.policies.people_seen import RADII_M
from hazbot_gym.policies.ssm import Ssm

try:
    import onnx
    from onnx import TensorProto, helper, numpy_helper
except ImportError as error:
    raise MissingExtra("onnx", "export") from error

OPSET, IR_VERSION = 17, 8  # of 2022, which every runtime reads


class _Graph:
    """Nodes and constants of a graph under construction; values are referred to by name."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, value: object, kind: type[np.generic] = np.float32) -> str:
        name = f"constant{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.array(value, kind), name))
        return name

    def add(self, operator: str, *inputs: str, outputs: int = 1, **attributes: Any) -> Any:
        """Append a node; return the name of its output, or the names of several."""
        names = [f"value{len(self.nodes)}_{i}" for i in range(outputs)]
        self.nodes.append(helper.make_node(operator, inputs, names, **attributes))
        return names[0] if outputs == 1 else names

    def call(self, name: str, value: str) -> None:
        """Give a value the name of an output."""
        self.nodes.append(helper.make_node("Identity", [value], [name]))


def onnx_model(plan: Plan) -> bytes:
    """Return the ONNX file of a plan.

    Raises:
        InvalidInput: The policy has no network, or its base rule is not exported.
    """
    if plan.actor is None:
        raise InvalidInput(f"format: 'onnx' is for networks, {plan.spec!r} is a rule; allowed is c")
    if not isinstance(plan.rule, Constant | Ssm | None):
        raise InvalidInput(
            f"format: 'onnx' has no base rule {type(plan.rule).__name__}, as {plan.spec!r} has; "
            "allowed is c"
        )
    if plan.listens:
        raise InvalidInput(
            f"format: 'onnx' has no memory of echoes, by which the base rule of {plan.spec!r} "
            "estimates people on the tier sonar; allowed is c"
        )
    graph = _Graph()
    is_valid = _valid(graph, plan)
    safe = graph.add("Where", is_valid, "observation", graph.constant(0.0))
    outputs, states = _network(graph, plan, safe)
    is_odd = graph.add("Or", graph.add("IsInf", outputs), graph.add("IsNaN", outputs))
    works = graph.add("And", is_valid, _all(graph, graph.add("Not", is_odd)))
    answer = _head(graph, plan.actor, outputs)
    if plan.rule is not None:
        answer = _corrected(graph, plan, safe, answer)
    graph.call("action", graph.add("Where", works, answer, graph.constant(-1.0)))
    for name, state in states.items():
        graph.call(f"next_{name}", graph.add("Where", works, state, name))
    return _file(graph, plan)


def _all(graph: _Graph, flags: str) -> str:
    """Return (N, 1) whether all flags of a row are set."""
    numbers = graph.add("Cast", flags, to=TensorProto.INT32)
    every = graph.add("ReduceMin", numbers, axes=[1], keepdims=1)
    out: str = graph.add("Cast", every, to=TensorProto.BOOL)
    return out


def _valid(graph: _Graph, plan: Plan) -> str:
    """Return (N, 1) whether all entries are within their bounds, as ``policies/guard.py``."""
    low = graph.constant(plan.layout.low - np.float32(ROUNDING))
    high = graph.constant(plan.layout.high + np.float32(ROUNDING))
    above = graph.add("GreaterOrEqual", "observation", low)
    below = graph.add("LessOrEqual", "observation", high)
    return _all(graph, graph.add("And", above, below))


def _network(graph: _Graph, plan: Plan, x: str) -> tuple[str, dict[str, str]]:
    """Return the outputs before the head, and the next LSTM state by name."""
    actor, states = plan.actor, {}
    assert actor is not None
    if actor.normalisation is not None:
        mean, variance, clip, epsilon = actor.normalisation
        x = graph.add("Sub", x, graph.constant(mean))
        x = graph.add("Div", x, graph.constant(np.sqrt(variance + np.float32(epsilon))))
        x = graph.add("Clip", x, graph.constant(-clip), graph.constant(clip))
    if actor.lstm is not None:
        gates = _linear(graph, graph.add("Concat", x, "hidden", axis=1), *actor.lstm.gates)
        i, f, g, o = graph.add("Split", gates, outputs=4, axis=1)
        kept = graph.add("Mul", graph.add("Sigmoid", f), "cell")
        new = graph.add("Mul", graph.add("Sigmoid", i), graph.add("Tanh", g))
        cell = graph.add("Add", kept, new)
        x = graph.add("Mul", graph.add("Sigmoid", o), graph.add("Tanh", cell))
        states = {"hidden": x, "cell": cell}
    for layer in actor.layers[:-1]:
        x = graph.add({"tanh": "Tanh", "relu": "Relu"}[actor.activation], _linear(graph, x, *layer))
    return _linear(graph, x, *actor.layers[-1]), states


def _linear(graph: _Graph, x: str, weight: Any, bias: Any) -> str:
    out: str = graph.add("Gemm", x, graph.constant(weight), graph.constant(bias))
    return out


def _head(graph: _Graph, actor: Actor, y: str) -> str:
    if actor.head == "squashed":
        out: str = graph.add("Tanh", y)
        return out
    if actor.head == "clipped":
        return _bounded(graph, y)
    outputs = actor.layers[-1].bias.size
    # levels: 2 k / (n - 1) - 1 for the largest of n values
    best = graph.add("Cast", graph.add("ArgMax", y, axis=1), to=TensorProto.FLOAT)
    step = graph.add("Mul", best, graph.constant(2.0 / max(outputs - 1, 1)))
    level: str = graph.add("Sub", step, graph.constant(1.0))
    return level


def _bounded(graph: _Graph, y: str) -> str:
    out: str = graph.add("Clip", y, graph.constant(-1.0), graph.constant(1.0))
    return out


def _corrected(graph: _Graph, plan: Plan, x: str, correction: str) -> str:
    """Return the action of the base rule with the network's correction."""
    action = (
        _constant(graph, plan.rule) if isinstance(plan.rule, Constant) else _ssm(graph, plan, x)
    )
    change = graph.add("Mul", correction, graph.constant(plan.scale))
    return _bounded(graph, graph.add("Add", action, change))


def _constant(graph: _Graph, rule: Constant) -> str:
    return graph.constant(2.0 * rule.fraction - 1.0)


def _ssm(graph: _Graph, plan: Plan, x: str) -> str:
    """Return the action of ``policies/ssm.py`` in its mode ``strict``, in double precision."""
    rule, ssm = plan.rule, SsmThresholds()
    assert isinstance(rule, Ssm)
    names, fields = plan.layout.names, plan.layout.fields
    present, distance = (
        [names.index(f"person{k}_{name}") for k in range(plan.layout.person_slots)]
        for name in ("present", "distance_m")
    )

    def double(value: float | Floats) -> str:
        return graph.constant(value, np.float64)

    def column(index: list[int]) -> str:
        values = graph.add("Gather", x, graph.constant(index, np.int64), axis=1)
        out: str = graph.add("Cast", values, to=TensorProto.DOUBLE)
        return out

    a, b = ssm.braking_mps2, ssm.braking_mps2 * ssm.reaction_s + ssm.approach_mps
    taken_m = ssm.approach_mps * ssm.reaction_s + ssm.intrusion_m + ssm.uncertainty_m
    metres = graph.add("Mul", column(distance), double(fields[distance[0]].scale))
    spare = graph.add("Sub", metres, double(RADII_M + rule.margin_m + taken_m))
    under = graph.add("Mul", graph.add("Max", spare, double(0.0)), double(2.0 * a))
    root = graph.add("Sqrt", graph.add("Add", under, double(b * b)))
    speed = graph.add("Sub", root, double(b))
    is_there = graph.add("Greater", column(present), double(0.5))
    speed = graph.add("Where", is_there, speed, double(rule.nominal_mps))
    slowest = graph.add("ReduceMin", speed, axes=[1], keepdims=1)
    share = graph.add("Div", slowest, double(rule.nominal_mps))
    share = graph.add("Cast", graph.add("Clip", share, double(0.0), double(1.0)), to=1)
    action: str = graph.add(
        "Sub", graph.add("Mul", share, graph.constant(2.0)), graph.constant(1.0)
    )
    return action


def _file(graph: _Graph, plan: Plan) -> bytes:
    def value(name: str, width: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", width])

    states = ("hidden", "cell") if plan.memory else ()
    inputs = [value("observation", plan.layout.width)]
    outputs = [value("action", 1)]
    inputs += [value(name, plan.memory) for name in states]
    outputs += [value(f"next_{name}", plan.memory) for name in states]
    body = helper.make_graph(graph.nodes, "hazbot_policy", inputs, outputs, graph.constants)
    opsets = [helper.make_opsetid("", OPSET)]
    model = helper.make_model(body, opset_imports=opsets, producer_name="hazbot_gym")
    model.ir_version = IR_VERSION
    about = as_json(plan, golden_of(plan, count=0))
    del about["observations"], about["starts"], about["actions"]
    helper.set_model_props(model, {name: json.dumps(about[name]) for name in about})
    onnx.checker.check_model(model, full_check=True)
    data: bytes = model.SerializeToString()
    return data

from __future__ import annotations

import json
from pathlib import Path

import numba
import numpy as np
import numpy.typing as npt
import pytest
import skfuzzy
from skfuzzy import control

from hazbot_gym.core.fuzzy import gauss, triangle
from hazbot_gym.core.fuzzy_pid import (
    TERMS,
    WIDTH,
    FuzzyPid,
    fuzzy_pid_gains,
    gain_table,
    infer,
    look_up,
    rule_tables,
)
from hazbot_gym.core.pid import PidGains
from hazbot_gym.core.state import Floats

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "fuzzy_pid.json").read_text(encoding="utf-8")
)
RULES = rule_tables()


@numba.njit
def compiled(e: float, ec: float, rules: npt.NDArray[np.int64]) -> tuple[float, float, float]:
    return infer(e, ec, rules)


@pytest.fixture(scope="module")
def table() -> Floats:
    return gain_table()


def aggregated(e: float, ec: float, output: int, x: Floats) -> Floats:
    """Return the cut and joined output terms at x, with scikit-fuzzy's own calls."""
    centres = np.arange(-3.0, 4.0)
    on_e = np.array([skfuzzy.gaussmf(np.array([e]), c, WIDTH)[0] for c in centres])
    on_ec = np.array([skfuzzy.gaussmf(np.array([ec]), c, WIDTH)[0] for c in centres])
    weights = np.fmin(on_e[:, None], on_ec[None, :])
    joined = np.zeros_like(x)
    for term in range(-3, 4):
        strength = weights[RULES[output] == term].max(initial=0.0)
        shape = skfuzzy.trimf(x, [term - 1.0, term, term + 1.0])
        joined = np.fmax(joined, np.fmin(strength, shape))
    return joined


def test_first_rule_of_each_table_is_read_as_printed() -> None:
    assert RULES.shape == (3, 7, 7)
    assert RULES[:, 0, 0].tolist() == [3, -3, 1]  # PB, NB, PS
    assert RULES[:, 6, 1].tolist() == [0, 0, 2]  # ZO, ZO, PM


@pytest.mark.parametrize("row", REFERENCE["outputs"])
def test_outputs_are_those_of_the_specification(row: dict[str, object]) -> None:
    assert infer(row["e"], row["ec"], RULES) == pytest.approx(
        row["F"], abs=REFERENCE["tolerance_trapezoid"]
    )


@pytest.mark.parametrize("row", REFERENCE["outputs"])
def test_specification_took_the_plain_sum_of_101_points(row: dict[str, object]) -> None:
    x = np.linspace(-3.0, 3.0, 101)
    joined = [aggregated(row["e"], row["ec"], output, x) for output in range(3)]

    assert [float(m @ x / m.sum()) for m in joined] == pytest.approx(
        row["F"], abs=REFERENCE["tolerance_plain_sum"]
    )


def test_centroid_is_within_0_004_of_the_exact_one() -> None:
    x = np.linspace(-3.0, 3.0, 6001)
    for e in np.linspace(-3.0, 3.0, 9):
        for ec in np.linspace(-2.7, 3.0, 7):
            exact = [
                skfuzzy.defuzz(x, aggregated(e, ec, output, x), "centroid") for output in range(3)
            ]
            assert infer(e, ec, RULES) == pytest.approx(exact, abs=0.004)


def test_inference_is_that_of_scikit_fuzzy_on_a_grid() -> None:
    # Memberships, cut, union and centroid of scikit-fuzzy on a universe that holds all corners.
    axis, x = np.linspace(-3.0, 3.0, 20), np.linspace(-3.0, 3.0, 601)
    shapes = np.stack([skfuzzy.trimf(x, [c - 1.0, c, c + 1.0]) for c in range(-3, 4)])
    seen = np.stack([skfuzzy.gaussmf(axis, c, WIDTH) for c in range(-3, 4)], axis=1)
    worst = 0.0
    for i, e in enumerate(axis):
        for j, ec in enumerate(axis):
            weights = np.fmin(seen[i][:, None], seen[j][None, :])
            oracle = [
                skfuzzy.defuzz(x, np.fmin(_strengths(weights, rules)[:, None], shapes).max(axis=0),
                               "centroid")
                for rules in RULES
            ]  # fmt: skip
            worst = max(worst, np.abs(np.subtract(compiled(e, ec, RULES), oracle)).max())
    assert worst < 0.005


def _strengths(weights: Floats, rules: npt.NDArray[np.int64]) -> Floats:
    """Return the activation of each output term: (7, 7) weights and codes to (7,)."""
    return np.array([weights[rules == code].max(initial=0.0) for code in range(-3, 4)])


def test_inference_is_that_of_scikit_fuzzy_s_control_system() -> None:
    # scikit-fuzzy looks its memberships up by linear interpolation on the universe, and adds the
    # points where a term meets its cut to the 101, which makes its centroid nearly exact.
    names = ("kp", "ki", "kd")
    e, ec = (control.Antecedent(np.linspace(-3.0, 3.0, 601), n) for n in ("e", "ec"))
    outputs = [control.Consequent(np.linspace(-3.0, 3.0, 101), n) for n in names]
    for variable in (e, ec):
        for c, term in enumerate(TERMS):
            variable[term] = skfuzzy.gaussmf(variable.universe, c - 3, WIDTH)
    for output in outputs:
        for c, term in enumerate(TERMS):
            output[term] = skfuzzy.trimf(output.universe, [c - 4, c - 3, c - 2])
    rules = [
        control.Rule(
            e[TERMS[i]] & ec[TERMS[j]],
            [output[TERMS[RULES[k, i, j] + 3]] for k, output in enumerate(outputs)],
        )
        for i in range(7)
        for j in range(7)
    ]
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)
    for point in ((0.0, 0.0), (2.25, 0.0), (-1.3, 0.7), (0.4, -2.1), (2.9, 2.6)):
        simulation.input["e"], simulation.input["ec"] = point
        simulation.compute()
        oracle = [simulation.output[name] for name in names]
        assert infer(*point, RULES) == pytest.approx(oracle, abs=0.005)


def test_compiled_inference_is_that_of_plain_python(table: Floats) -> None:
    # The table's grid points are the compiled inference itself.
    for i in range(0, 121, 15):
        for j in range(0, 121, 12):
            plain = infer(0.05 * i - 3.0, 0.05 * j - 3.0, RULES)
            assert table[i, j] == pytest.approx(plain, abs=1e-12)


def test_table_is_within_0_03_of_the_inference(table: Floats) -> None:
    rng = np.random.default_rng(3)
    differences = np.array(
        [
            np.subtract(look_up(e, ec, table), compiled(e, ec, RULES))
            for e, ec in rng.uniform(-3.0, 3.0, (2000, 2))
        ]
    )

    assert np.abs(differences).max() < 0.03
    assert np.abs(differences).mean() < 0.001


def test_look_up_holds_inputs_to_the_table(table: Floats) -> None:
    assert look_up(99.0, -99.0, table) == pytest.approx(tuple(table[120, 0]))
    assert look_up(-99.0, 99.0, table) == pytest.approx(tuple(table[0, 120]))


def test_resting_gains_are_those_of_the_specification(table: Floats) -> None:
    gains = fuzzy_pid_gains(0.0, 0.0, PidGains(), FuzzyPid(), table)

    assert gains == pytest.approx(
        REFERENCE["resting_gains"], abs=REFERENCE["resting_gains_tolerance"]
    )


def test_gains_are_never_negative(table: Floats) -> None:
    wide = FuzzyPid(kp_span=30.0, ki_span=30.0, kd_span=30.0)
    gains = [
        fuzzy_pid_gains(error, rate, PidGains(), wide, table)
        for error in (-3.0, 0.0, 3.0)
        for rate in (-20.0, 0.0, 20.0)
    ]

    assert np.min(gains) == 0.0


def test_start_from_rest_raises_kp_only_under_the_negative_sign(table: Floats) -> None:
    def kp(sign: float) -> float:
        return fuzzy_pid_gains(2.5, 0.0, PidGains(), FuzzyPid(sign=sign), table).kp

    assert kp(-1.0) > 9.39 > kp(1.0)


def test_symmetric_tables_do_not_depend_on_the_sign() -> None:
    rules = rule_tables("symmetric")
    for point in ((1.3, 0.4), (2.0, -1.0), (0.0, 1.5)):
        mirrored = infer(-point[0], -point[1], rules)
        assert infer(*point, rules) == pytest.approx(mirrored, abs=1e-12)
    assert (rules[:, :3] == RULES[:, :3]).all()


def test_membership_widths_cross_at_a_half() -> None:
    assert gauss(0.5, 0.0, WIDTH) == pytest.approx(0.5, abs=1e-4)
    assert triangle(0.5, 0.0, 1.0) == 0.5

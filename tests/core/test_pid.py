from __future__ import annotations

import math

import pytest

from hazbot_gym.core.pid import (
    PLANTS,
    PidGains,
    Plant,
    filtered_derivative,
    lagged_input,
    motor_gain,
    motor_step,
    pid_law,
)

DT_S = 0.01


def test_control_law_adds_its_three_terms() -> None:
    assert pid_law(1.0, 0.5, -0.2, PidGains()) == pytest.approx(9.0 + 1.0 - 0.6)


def test_derivative_of_a_ramp_settles_at_its_slope() -> None:
    derivative, error = 0.0, 0.0
    for _ in range(200):
        derivative = filtered_derivative(derivative, error + 0.03, error, DT_S, Tf=0.05)
        error += 0.03

    assert derivative == pytest.approx(3.0)


def test_first_sample_has_no_derivative() -> None:
    assert filtered_derivative(0.0, 2.5, math.nan, DT_S, Tf=0.05) == 0.0


def test_derivative_without_filter_is_the_difference_quotient() -> None:
    assert filtered_derivative(7.0, 0.02, 0.01, DT_S, Tf=0.0) == pytest.approx(1.0)


def test_motor_reaches_63_percent_after_its_time_constant() -> None:
    plant, speed = PLANTS["A0"], 0.0
    for _ in range(300):
        speed = motor_step(speed, 1.0, motor_gain(plant, True), plant.T1, DT_S)

    assert speed == pytest.approx(plant.K * (1.0 - math.exp(-1.0)), abs=0.003)


def test_right_wheel_is_the_weaker_one_when_the_mismatch_is_negative() -> None:
    plant = Plant(K=2.0, a=-0.25)

    assert motor_gain(plant, is_right=True) == pytest.approx(1.5)
    assert motor_gain(plant, is_right=False) == pytest.approx(2.5)


def test_input_passes_at_once_without_extra_lag_and_gradually_with_it() -> None:
    assert lagged_input(0.0, 4.0, Plant(T2=0.0), DT_S) == 4.0
    assert lagged_input(0.0, 4.0, Plant(T2=0.1), DT_S) == pytest.approx(0.4)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_input_is_bounded(sign: float) -> None:
    assert lagged_input(0.0, sign * 25.0, Plant(u_max=10.0), DT_S) == sign * 10.0


def test_loop_brings_a_wheel_to_its_commanded_speed() -> None:
    plant, gains = PLANTS["A"], PidGains()
    speed, integral, derivative, before = 0.0, 0.0, 0.0, math.nan
    for _ in range(4000):
        error = 2.5 - speed
        integral += error * DT_S
        derivative = filtered_derivative(derivative, error, before, DT_S, plant.Tf)
        before = error
        u = pid_law(error, integral, derivative, gains)
        speed = motor_step(speed, u, motor_gain(plant, True), plant.T1, DT_S)

    assert speed == pytest.approx(2.5, abs=1e-3)

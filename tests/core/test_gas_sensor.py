"""The lag of a gas sensor against its closed form, its alarm, and sensors given as data."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from hazbot_gym.core.gas_sensor import (
    GAS_SENSORS,
    HOUR_S,
    QUIET,
    GasSensor,
    Nose,
    clear_smell,
    nose_of,
    reading_rate,
    sense_gas,
    steady_response,
)
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.state import SMELL, Floats, Records, as_record, records

KEY = np.uint64(3)
# Its steady response is the concentration in ppm, and nothing is random.
LINEAR = GasSensor(rise_s=3.0, decay_s=8.0, half_ppm=1.0, exponent=1.0)


class Sensed(NamedTuple):
    response: Floats
    reading: Floats
    alarm: Floats
    onset: Floats
    rate_per_s: Floats
    since_peak_s: Floats


@lean_kernel
def _sniff(smells: Records, noses: Records, values: Floats, out: Floats, key: np.uint64) -> None:
    smell = smells[0]
    clear_smell(smell)
    for i in range(values.shape[0]):
        sense_gas(smell, values[i], noses[0], key, i)
        out[0, i], out[1, i] = smell.response, smell.reading
        out[2, i], out[3, i] = smell.alarm, smell.onset
        out[4, i], out[5, i] = reading_rate(smell), smell.since_peak_s


def sniffed(nose: Nose, values: Floats) -> Sensed:
    """Return the outputs of a sensor for the concentration at each decision from the reset on."""
    out = np.empty((len(Sensed._fields), len(values)))
    _sniff(records(SMELL, 1), as_record(nose), np.asarray(values, float), out, KEY)
    return Sensed(*out)


def silent(sensor: GasSensor, decision_s: float) -> Nose:
    """Return a sensor without noise whose alarm threshold is 1."""
    return nose_of(sensor, decision_s)._replace(noise=0.0, threshold=1.0)


def direct() -> Nose:
    """Return a sensor whose reading is the concentration, at once."""
    return silent(LINEAR, 0.1)._replace(rise=1.0, decay=1.0)


# --- response ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GAS_SENSORS)
@pytest.mark.parametrize("decision_s", [0.1, 0.5])
def test_response_rises_and_decays_with_the_sensors_time_constants(
    name: str, decision_s: float
) -> None:
    sensor, steps = GAS_SENSORS[name], 40
    gas = np.r_[np.full(steps, 100.0), np.zeros(steps)]
    response = sniffed(nose_of(sensor, decision_s), gas).response
    times = decision_s * np.arange(1, steps + 1)

    steady = steady_response(100.0, sensor.half_ppm, sensor.exponent)
    rising = steady * (1.0 - np.exp(-times / sensor.rise_s))
    assert response[:steps] == pytest.approx(rising, rel=1e-12)
    assert response[steps:] == pytest.approx(
        rising[-1] * np.exp(-times / sensor.decay_s), rel=1e-12
    )


@pytest.mark.parametrize(
    ("name", "factor", "power", "in_air"),
    [
        ("TGS2611", 38.46, -0.4289, 8.8),  # methane
        ("TGS2620", 120.6, -0.4877, 21.0),  # methane
        ("TGS2600", 0.6821, -0.3532, 1.0),  # hydrogen
    ],
)
def test_far_above_clean_air_the_response_is_gadens_line(
    name: str, factor: float, power: float, in_air: float
) -> None:
    """GADEN has the resistance over a reference, A c^B, and that of clean air."""
    sensor = GAS_SENSORS[name]
    for c_ppm in (3e3 * sensor.half_ppm, 3e4 * sensor.half_ppm):
        conductance = in_air / (factor * c_ppm**power)
        response = steady_response(c_ppm, sensor.half_ppm, sensor.exponent)
        assert 1.0 + response == pytest.approx(conductance, rel=5e-3)


def test_in_clean_air_there_is_no_response() -> None:
    for sensor in GAS_SENSORS.values():
        assert steady_response(0.0, sensor.half_ppm, sensor.exponent) == 0.0


# --- the lag of a robot that drives through a plume ----------------------------------------------

WIDTH_M, DECISION_S = 0.6, 0.02


def passage(speed_mps: float, rise_s: float, decay_s: float) -> tuple[Floats, Floats]:
    """Return times from the middle of a Gaussian plume [s], and the response on the way through."""
    times = np.arange(-6.0 * WIDTH_M / speed_mps, 6.0 * WIDTH_M / speed_mps + 60.0, DECISION_S)
    plume = np.exp(-0.5 * (speed_mps * times / WIDTH_M) ** 2)
    sensor = LINEAR._replace(rise_s=rise_s, decay_s=decay_s)
    return times, sniffed(nose_of(sensor, DECISION_S), plume).response


def closed_form(times: Floats, speed_mps: float, tau_s: float) -> Floats:
    """Return the plume behind a first-order lag: the exponentially modified Gaussian."""
    width_s = WIDTH_M / speed_mps
    share = width_s / tau_s
    tail = [
        math.exp(0.5 * share**2 - t / tau_s) * math.erfc((share - t / width_s) / math.sqrt(2.0))
        for t in times
    ]
    return math.sqrt(0.5 * math.pi) * share * np.array(tail)


@pytest.mark.parametrize("speed_mps", [0.1, 0.25, 0.5, 1.0])
def test_response_on_the_way_through_a_plume_is_the_closed_form(speed_mps: float) -> None:
    times, response = passage(speed_mps, 3.44, 3.44)
    expected = closed_form(times, speed_mps, 3.44)
    assert np.abs(response - expected).max() < 0.01 * expected.max()
    late_s = times[response.argmax()]
    assert late_s == pytest.approx(times[expected.argmax()], abs=2.0 * DECISION_S)
    assert late_s > 0.0


def test_peak_falls_with_the_speed_as_the_closed_form_says() -> None:
    speeds, tau_s = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 6.0]), 3.44
    peaks = []
    for speed in speeds:
        times, response = passage(speed, tau_s, 15.71)  # a slow decay changes the tail alone
        peaks.append(response.max())
        assert peaks[-1] == pytest.approx(closed_form(times, speed, tau_s).max(), rel=0.01)
    assert np.all(np.diff(peaks) < 0.0)
    assert peaks[0] == pytest.approx(0.92, abs=0.05)  # slow: nearly the plume's own
    dose = math.sqrt(2.0 * math.pi) * WIDTH_M / (speeds[-1] * tau_s)
    assert peaks[-1] == pytest.approx(dose, rel=0.1)  # fast: what is inhaled on the way


# --- alarm ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("per_hour", [1.0, 60.0, 600.0])
def test_in_clean_air_alarms_are_as_frequent_as_asked_for(per_hour: float) -> None:
    sensor = GAS_SENSORS["TGS2611"]._replace(false_alarms_per_h=per_hour)
    expected = 400.0
    steps = round(expected / per_hour * HOUR_S / 0.1)
    sensed = sniffed(nose_of(sensor, 0.1), np.zeros(steps))
    assert abs(sensed.onset.sum() - expected) < 4.0 * math.sqrt(expected)
    assert sensed.reading.mean() == pytest.approx(0.0, abs=4.0 / math.sqrt(steps))


def test_alarm_starts_at_1_and_ends_below_quiet() -> None:
    below, above = QUIET - 0.01, QUIET + 0.01
    readings = [0.0, 0.99, above, 1.0, above, 1.5, above, below, above, 0.99, 1.2, 0.0, 1.0]
    sensed = sniffed(direct(), readings)

    assert sensed.reading == pytest.approx(readings)
    assert sensed.alarm.tolist() == [0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 1]
    assert sensed.onset.tolist() == [0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1]


def test_alarm_of_a_robot_that_starts_in_gas_belongs_to_the_first_decision() -> None:
    """No decision is judged at the reset, so that an alarm then would be reported by nobody."""
    sensed = sniffed(direct(), [5.0, 5.0, 5.0])
    assert sensed.alarm.tolist() == [0, 1, 1]
    assert sensed.onset.tolist() == [0, 1, 0]


def test_rate_of_a_steady_rise_is_its_slope() -> None:
    sensed = sniffed(direct(), 0.03 * np.arange(200.0))
    assert sensed.rate_per_s[-1] == pytest.approx(0.3, rel=0.06)
    assert sniffed(direct(), np.full(200, 0.7)).rate_per_s[-1] == pytest.approx(0.0, abs=1e-6)


def test_time_since_the_peak_starts_again_at_every_larger_one() -> None:
    sensed = sniffed(direct(), [*[1.0] * 20, *[0.0] * 10, *[0.5] * 20, *[2.0] * 10])
    assert sensed.since_peak_s[:20].tolist() == [0.0] * 20
    assert sensed.since_peak_s[49] == pytest.approx(3.0)
    assert sensed.since_peak_s[-1] == 0.0


def test_the_history_holds_the_reading_of_each_of_the_last_ten_seconds() -> None:
    sensed, nose = records(SMELL, 1), as_record(nose_of(GAS_SENSORS["TGS2611"], 0.1))
    smooth = []
    for step in range(151):
        _sense_one(sensed, 0.2 * step, nose, step)
        smooth.append(float(sensed["smooth"][0]))
    # A full second is decision 10 k; the entry is the reading of the decision before.
    assert sensed["past"][0].tolist() == [smooth[149 - 10 * k] for k in range(10)]
    assert len(set(smooth)) == len(smooth)


@lean_kernel
def _sense_one(smells: Records, c_ppm: float, noses: Records, step: int) -> None:
    sense_gas(smells[0], c_ppm, noses[0], np.uint64(5), step)

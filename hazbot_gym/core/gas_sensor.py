"""Metal-oxide gas sensor: power-law response, first-order lag, noise, and an alarm.

    S = (1 + c / c_0)^b - 1          steady response, relative increase of the conductance
    dr/dt = (S - r) / tau            tau = tau_rise if S > r, else tau_decay
    reading = (r + noise) / T        in units of the alarm threshold T

For c far above c_0 the response is the power law of the data sheets. Time constants and power laws
for methane and hydrogen are those of GADEN (Monroy et al. 2017, GADEN: a 3D gas dispersion
simulator; Monroy, Gonzalez-Jimenez and Blanco 2012, Overcoming the slow recovery of MOX gas
sensors through a system modeling approach): c_0 is where its line meets clean air. The noise is our
choice.

The alarm starts where the reading exceeds 1, not before the first decision, and ends below
``QUIET``. T follows from the rate of false alarms: noise is white and normal, so that T = sigma z
with its quantile z of 1 - rate dt.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Annotated, Literal, NamedTuple

import numpy as np
from annotated_types import Gt, Le

from hazbot_gym.core.jit import scalar
from hazbot_gym.core.noise import GAS_READING, normal_pair, uniform4
from hazbot_gym.core.state import GAS_HISTORY, SmellRecord

QUIET = 0.8  # reading at which an alarm ends
SMOOTHING_S = 1.0  # time constant of both filters of the rate
HOUR_S = 3600.0


class GasSensor(NamedTuple):
    """One gas sensor."""

    rise_s: Annotated[float, Gt(0)]  # tau_rise
    decay_s: Annotated[float, Gt(0)]  # tau_decay
    half_ppm: Annotated[float, Gt(0)]  # c_0
    exponent: Annotated[float, Gt(0), Le(2)]  # b
    noise: Annotated[float, Gt(0)] = 0.02  # standard deviation of the response's noise
    false_alarms_per_h: Annotated[float, Gt(0), Le(3600)] = 1.0  # in clean air


GAS_SENSORS = {
    "TGS2611": GasSensor(rise_s=3.44, decay_s=6.35, half_ppm=31.1, exponent=0.4289),  # methane
    "TGS2620": GasSensor(rise_s=2.96, decay_s=15.71, half_ppm=36.0, exponent=0.4877),  # methane
    "TGS2600": GasSensor(rise_s=4.8, decay_s=18.75, half_ppm=0.339, exponent=0.3532),  # hydrogen
}
GasSensorChoice = Literal["TGS2611", "TGS2620", "TGS2600"] | GasSensor


def gas_sensor_of(choice: GasSensorChoice) -> GasSensor:
    """Return a sensor, by name or in full."""
    return GAS_SENSORS[choice] if isinstance(choice, str) else choice


def threshold_of(sensor: GasSensor, decision_s: float) -> float:
    """Return the response T at which the alarm starts, from the rate of false alarms."""
    exceedance = sensor.false_alarms_per_h * decision_s / HOUR_S
    return sensor.noise * NormalDist().inv_cdf(1.0 - min(exceedance, 0.5 - 1e-6))


class Nose(NamedTuple):
    """A gas sensor sampled once per decision, as numbers for kernels."""

    rise: float  # 1 - exp(-dt / tau_rise), share of a step closed in a decision
    decay: float
    smoothing: float
    half_ppm: float
    exponent: float
    noise: float
    threshold: float  # T
    decision_s: float
    per_second: int  # decisions between two entries of the history


def nose_of(sensor: GasSensor, decision_s: float) -> Nose:
    """Return a sensor's numbers for kernels."""

    def share(tau_s: float) -> float:
        return -math.expm1(-decision_s / tau_s)

    return Nose(
        rise=share(sensor.rise_s),
        decay=share(sensor.decay_s),
        smoothing=share(SMOOTHING_S),
        half_ppm=sensor.half_ppm,
        exponent=sensor.exponent,
        noise=sensor.noise,
        threshold=threshold_of(sensor, decision_s),
        decision_s=decision_s,
        per_second=max(round(1.0 / decision_s), 1),
    )


@scalar
def steady_response(c_ppm: float, half_ppm: float, exponent: float) -> float:
    """Return the steady response S = (1 + c / c_0)^b - 1."""
    return float((1.0 + c_ppm / half_ppm) ** exponent) - 1.0


@scalar
def clear_smell(smell: SmellRecord) -> None:
    """Reset a sensor to clean air."""
    smell.s_m = smell.concentration_ppm = smell.response = smell.reading = 0.0
    smell.smooth = smell.smoother = smell.peak = smell.since_peak_s = 0.0
    smell.alarm = smell.onset = smell.has_sounded = 0
    for k in range(GAS_HISTORY):
        smell.past[k] = 0.0


@scalar
def sense_gas(smell: SmellRecord, c_ppm: float, nose: Nose, key: np.uint64, step: int) -> None:
    """Update a sensor by one decision at a concentration.

    Args:
        smell: Record of type ``SMELL``.
        c_ppm: Concentration at the sensor.
        nose: Numbers of the sensor.
        key: Key of the scenario's noise.
        step: Number of the decision since the reset.
    """
    target = steady_response(c_ppm, nose.half_ppm, nose.exponent)
    share = nose.rise if target > smell.response else nose.decay
    smell.concentration_ppm = c_ppm
    smell.response += share * (target - smell.response)
    u1, u2, _, _ = uniform4(key, GAS_READING, step, 0)
    smell.reading = (smell.response + nose.noise * normal_pair(u1, u2)[0]) / nose.threshold
    if step % nose.per_second == 0:
        for k in range(GAS_HISTORY - 1, 0, -1):
            smell.past[k] = smell.past[k - 1]
        smell.past[0] = smell.smooth
    smell.smooth += nose.smoothing * (smell.reading - smell.smooth)
    smell.smoother += nose.smoothing * (smell.smooth - smell.smoother)
    smell.since_peak_s += nose.decision_s
    if smell.smooth > smell.peak:
        smell.peak, smell.since_peak_s = smell.smooth, 0.0
    was_on = smell.alarm == 1
    is_on = step > 0 and smell.reading >= (QUIET if was_on else 1.0)
    smell.alarm = 1 if is_on else 0
    smell.onset = 1 if is_on and not was_on else 0
    if is_on:
        smell.has_sounded = 1


@scalar
def reading_rate(smell: SmellRecord) -> float:
    """Return the rate of the reading behind two filters [1/s]."""
    return (smell.smooth - smell.smoother) / SMOOTHING_S

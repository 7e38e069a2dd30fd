from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.state import PERSON, PRESENT, Floats, Records, as_record, records


class Inner(NamedTuple):
    width_m: float = 2.5
    steps: int = 7


class Outer(NamedTuple):
    gain: float = 0.1
    inner: Inner = Inner()
    is_on: bool = True


@kernel
def sum_fields(parameters: Records) -> float:
    p = parameters[0]
    return p.gain + 10.0 * p.inner.width_m + 100.0 * p.inner.steps + 1000.0 * p.is_on


@kernel
def mark_present(people: Records, out: Floats) -> None:
    for i in range(people.shape[0]):
        people[i].status = PRESENT
        out[i] = people[i].x


def test_record_has_the_fields_and_values_of_the_named_tuple() -> None:
    record = as_record(Outer(gain=0.3, inner=Inner(1.5, 3), is_on=False))

    assert record.shape == (1,)
    assert record.dtype.names == Outer._fields
    assert record["inner"].dtype.names == Inner._fields
    gain, inner, is_on = record[0].item()
    assert Outer(gain, Inner(*inner), bool(is_on)) == Outer(0.3, Inner(1.5, 3), False)


def test_kernel_reads_a_record_like_the_named_tuple() -> None:
    assert sum_fields(as_record(Outer())) == pytest.approx(0.1 + 25.0 + 700.0 + 1000.0)


def test_record_of_something_else_than_numbers_is_refused() -> None:
    with pytest.raises(KeyError):
        as_record(Outer(gain="strong"))  # type: ignore[arg-type]


def test_records_begin_at_zero_and_can_be_changed_by_kernels() -> None:
    people = records(PERSON, 2)
    assert people.tobytes() == bytes(people.nbytes)
    people["x"] = 3.0, 4.0
    out = np.empty(2)

    mark_present(people, out)

    assert out.tolist() == [3.0, 4.0]
    assert people["status"].tolist() == [PRESENT, PRESENT]

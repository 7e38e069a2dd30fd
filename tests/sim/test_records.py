"""The types of records are the dtypes of their arrays, field by field."""

import pytest

from hazbot_gym.core import state
from hazbot_gym.sim import batched_worlds, lanes, walkers
from hazbot_gym.task import step_record


@pytest.mark.parametrize(
    ("kind", "dtype"),
    [
        (state.RobotRecord, state.ROBOT),
        (state.WheelRecord, state.WHEEL),
        (state.PersonRecord, state.PERSON),
        (state.TrackRecord, state.TRACK),
        (step_record.StepRecord, step_record.STEP),
        (lanes.DriveLanes, lanes.DRIVE_LANES),
        (batched_worlds.Group, batched_worlds.GROUP),
        (walkers.WalkersRecord, walkers.WALKERS),
        (walkers.PushesRecord, walkers.PUSHES),
    ],
)
def test_record_has_the_fields_of_its_dtype(kind, dtype):
    assert set(kind.__annotations__) == set(dtype.names)
    for name, annotation in kind.__annotations__.items():
        base, shape = dtype[name].base, dtype[name].shape
        if base.names is None:
            assert (annotation in ("Ints", "int")) == (base.kind == "i"), name
            assert (annotation in ("int", "float")) == (shape == ()), name

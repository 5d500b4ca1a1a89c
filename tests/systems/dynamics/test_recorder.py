"""Records of a run, and their removal when a step is repeated."""

import numpy as np

import ropeway as rw
from ropeway.systems.dynamics.load_crossings import Crossing
from ropeway.systems.dynamics.recorder import Recorder
from ropeway.systems.statics.line_state import LineState
from support import schedule_lines


def test_a_recorder_returns_to_its_checkpoint() -> None:
    state, recorder = LineState.cold(rw.assemble(schedule_lines.line(4, 2))), Recorder()
    recorder.record(state, on_grid=True)
    recorder.note(state, Crossing(0.0, 0.0, 0, 1, 2, True), "crossing forward")
    checkpoint = recorder.checkpoint()
    state.point.x[:] += 1.0
    recorder.record(state, exact=False)
    recorder.note(state, Crossing(0.0, 0.0, 0, 2, 1, True), "crossing forward")
    assert (recorder.on_grid.tolist(), recorder.exact.tolist()) == ([True, False], [True, False])
    recorder.rewind(checkpoint)
    (record,) = recorder.records
    assert np.array_equal(record.x, state.point.x - 1.0)
    assert [(e.component, e.value, e.load) for e in recorder.events] == [("s1", 3, state.runs[0].loads.names[2])]

"""Binary records of an analysis: the values that OpenSees has, one row per committed step."""

import errno
from types import SimpleNamespace

import numpy as np
import openseespy.opensees as ops
import pytest

from skewbridge.analysis.trace import Recorder
from skewbridge.bridge.model import domain
from skewbridge.study import task


def record_an_oscillator(steps: int) -> tuple[Recorder, np.ndarray]:
    """Return the recorder of a driven oscillator, and its readings from Python, time first."""
    ops.node(1, 0.0, 0.0, 0.0)
    ops.node(2, 0.0, 0.0, 0.0)
    ops.fix(1, 1, 1, 1, 1, 1, 1)
    ops.fix(2, 0, 1, 1, 1, 1, 1)
    ops.mass(2, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    ops.uniaxialMaterial("Elastic", 1, 40.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 10.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", 1e-12, 10)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient", "-noWarnings")
    recorder = Recorder()
    recorder.nodes("moves", (2,), 6, "disp")
    recorder.elements("springs", (1,), "basicForce")
    recorder.elements("none", (), "basicForce")
    recorder.record()
    rows = [[0.0] * 8]
    for size_s in np.resize([0.01, 0.0025], steps).tolist():
        assert ops.analyze(1, size_s) == 0
        rows.append([ops.getTime(), *ops.nodeDisp(2), *ops.basicForce(1)])
    return recorder, np.array(rows)


def test_records_have_the_values_of_every_step_to_the_bit() -> None:
    with domain():
        recorder, rows = record_an_oscillator(20)
        time_s, moves = recorder.read("moves")
        np.testing.assert_array_equal(time_s, rows[:, 0])
        np.testing.assert_array_equal(moves, rows[:, 1:7])
        np.testing.assert_array_equal(recorder.read("springs")[1], rows[:, 7:])
        assert recorder.read("none")[1].size == 0
        assert np.abs(moves).max() > 1e-3


def test_a_response_that_an_element_does_not_have_is_refused() -> None:
    with domain():
        recorder, _ = record_an_oscillator(1)
        with pytest.raises(ValueError, match=r"element 1 has no response \('rayleighForce',\)"):
            recorder.elements("damping", (1,), "rayleighForce")


def test_an_incomplete_record_names_the_disk() -> None:
    with domain():
        recorder, _ = record_an_oscillator(5)
        recorder.close()
        path = recorder.path("moves")
        path.write_bytes(path.read_bytes()[:-9])
        with pytest.raises(OSError, match="record of moves is incomplete") as caught:
            recorder.read("moves")
        assert caught.value.errno == errno.ENOSPC


def test_a_full_disk_stops_a_study_and_leaves_no_row(monkeypatch, tmp_path) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr(task, "analyse", full)
    given = SimpleNamespace(variant=None, excitation=None, settings=None, options=None)
    with pytest.raises(OSError, match="no space left"):
        task.analyse_task(given, tmp_path / "log", lambda _time_s, _duration_s: None)

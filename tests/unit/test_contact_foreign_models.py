"""The documented script that adds contacts to models which know nothing of this package."""

import importlib
import sys
from pathlib import Path

import openseespy.opensees as ops
import pytest

from skewbridge.contact import ContactSet, make_step

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    ops.wipe()
    yield importlib.import_module("contact_in_your_model")
    ops.wipe()
    for name in ("contact_in_your_model", "foreign_models"):
        sys.modules.pop(name, None)


def test_the_script_runs_and_both_models_hit_and_slide(script):
    for ledger in script.main():
        assert ledger.closures >= 1
        assert ledger.max_normal_n > 0.0
        assert ledger.slip_work_j > 0.0
        # What the compression of a step differs from its prediction, over the largest limit.
        assert ledger.cone_violation_ratio < 0.02


def test_a_stop_that_is_never_reached_changes_nothing(script):
    foreign = importlib.import_module("foreign_models")
    tops = []
    for has_stop in (False, True):
        foreign.tower()
        stops = ContactSet()
        if has_stop:
            stops.add(9, 2, (-1.0, 0.0, 0.0), 10.0, 0.4, kn=1e5, kt=1e5)
        history = []
        for _ in range(500):
            assert make_step(stops, 0.002)
            history.append(ops.nodeDisp(2, 1))
        tops.append(history)
    assert tops[1] == pytest.approx(tops[0], abs=1e-12)


def test_the_script_is_short():
    code = (DOCS / "contact_in_your_model.py").read_text().split('"""', 2)[2]
    lines = [line for line in code.splitlines() if line.strip()]
    assert len(lines) <= 30

"""The paper's dynamic studies (figures 10 to 12, abutment models), and how they compare runs."""

import numpy as np
import pytest

from skewbridge.analysis.abutment_history import abutment_history
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import run_study
from skewbridge.verification.statements import STATEMENTS
from skewbridge.verification.studies import paper_runs
from skewbridge.verification.studies.bridge_friction import half_cycles, stick_slip_changes
from skewbridge.verification.studies.paper_runs import paper_variant
from strong_motion import strong_motion

T_S = np.linspace(0.0, 4.0, 401)


def test_half_cycles_lie_between_zero_crossings_and_notice_contact():
    plain, no_contact = np.sin(2 * np.pi * T_S), np.zeros(T_S.size, dtype=bool)
    both = np.column_stack([plain, plain])
    cycles = half_cycles(T_S, both, 0.9 * both, 0, [no_contact])
    assert cycles["change"].tolist() == pytest.approx([-0.1] * 8)
    assert cycles["together"].tolist() == pytest.approx([1.0] * 8)
    assert not cycles["has_contact"].any()
    both *= np.where(T_S < 2.0, 1.0, 0.1)[:, None]  # small half cycles are left out
    contact = (T_S > 0.2) & (T_S < 0.3)
    cycles = half_cycles(T_S, both, both, 1, [contact, no_contact])
    assert cycles["has_contact"].tolist() == [True, False, False, False]


def test_changes_between_sticking_and_slipping_count_while_closed():
    normal = np.array([[0.0], [10.0], [10.0], [10.0], [10.0], [0.0], [10.0]])
    friction = np.array([[0.0], [5.0], [2.0], [5.0], [5.0], [0.0], [1.0]])
    assert stick_slip_changes(normal, friction, 0.5) == 2


def test_missing_record_is_replaced_and_named(tmp_path, monkeypatch):
    monkeypatch.setenv("SKEWBRIDGE_RECORDS", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for found in (paper_runs.waho(), paper_runs.tarzana()):
        assert not found.is_paper_record
        assert found.label.startswith("synthetic")
    # without any motion the message states where to put one
    monkeypatch.setattr(paper_runs, "PACKAGE", tmp_path / "src" / "skewbridge")
    with pytest.raises(InputError, match="SKEWBRIDGE_RECORDS"):
        paper_runs.waho()


def abutment_run(variant, **options):
    excitation = Excitation(motion=strong_motion(duration_s=4.0))
    return abutment_history(variant, excitation, AnalysisSettings(), ModelOptions(**options))


def test_abutment_alone_closes_and_slips():
    rough, smooth = (abutment_run(paper_variant(friction_pct=friction)) for friction in (50, 0))
    for history in (rough, smooth):
        assert history.is_complete
        assert history.disp_m[0].tolist() == [0.0, 0.0]
        assert history.disp_m[:, 0].max() > 0.051
        assert sum(unit.closures for unit in history.ledger) > 2
        # Hysteresis: the pads act in the gap, and the backfill behind it as well.
        pushed = history.disp_m[:, 0].argmax()
        assert history.force_n[pushed, 0] > 1.0e6
    assert sum(unit.slip_work_j for unit in rough.ledger) > 1.0e3
    assert not smooth.friction_n.any()
    # The bound is a prediction to the end of the step: it is exceeded where the normal force turns.
    assert rough.friction_n.max() <= 0.5 * rough.normals_n.max() * 1.01


@pytest.mark.parametrize(("place", "free"), [("walls", "key"), ("keys", "backwall")])
def test_contacts_without_friction_carry_none_while_the_others_slip(place, free):
    history = abutment_run(paper_variant(skew_deg=25), friction_at=place)
    by_unit = dict(zip(history.unit_names, history.friction_n.T, strict=True))
    without = [peaks.max() for name, peaks in by_unit.items() if free in name]
    others = [peaks.max() for name, peaks in by_unit.items() if free not in name]
    assert max(without) == 0.0
    assert max(others) > 1.0e4


@pytest.mark.slow
@pytest.mark.parametrize("study", ["fig10", "fig11-12", "friction-source", "ladder"])
def test_dynamic_study_passes_and_judges_its_statements(study):
    found = run_study(study)
    failed = [row.quantity for row in found.comparisons if not row.is_passed]
    assert not failed
    assert bool(found.figures) is (study != "friction-source")  # that one is no figure of the paper
    judged = {finding.statement for finding in found.verdicts if finding.case}
    assert judged >= {key for key, row in STATEMENTS.items() if row.study == study}

"""Recovery steps: order, cost, sub-steps, an unchanged response; statuses of analyses.

Solutions fail after two iterations, so that their trial state is far from the committed one. The
reference is the same sequence of (sub-)steps without failures."""

import math
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis import recovery, step_loop
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.recovery import MAX_ITERATIONS, RECOVERY_STEPS, RecoveryStep
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import Watch
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.studies.bridge_friction import abutment_history
from strong_motion import strong_motion

DT_S = 0.01
STEPS = 120
TIGHT, ITERATIONS = 1e-11, 30
NEWMARK, HHT, HOUBOLT = ("Newmark", 0.5, 0.25), ("HHT", 0.9), ("Houbolt",)
VARIANT = variant()
ENERGY = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_energy_ratio")
TOO_STRICT = {"duration_s": 0.2, "tolerance_j": 1e-16, "reuse_tangent": False}
SETTINGS = {"duration_s": 3.0, "dt_s": 0.005, "tolerance_j": 1e-12, "reuse_tangent": False}
# Looser tests of later recovery steps are a difference of their own.
STRICT = tuple(replace(step, tolerance_j=0.0) for step in RECOVERY_STEPS)
# Solutions while free, about to close and in contact; none of them is the second of a step.
FAILING = {150, 310, 311, 430, 610}


@pytest.fixture(autouse=True)
def clean_domain():
    ops.wipe()
    yield
    ops.wipe()


def held_and_loaded(node, ground, constraints, *load, spring=("Steel01", 1, 8.0, 150.0, 0.1)):
    """Hold a node by a yielding spring, under a harmonic load; return the node."""
    ops.uniaxialMaterial(*spring)
    ops.element("zeroLength", 2, ground, node, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(node, *load)
    ops.constraints(constraints)
    return node


def spring_and_mass(**options):
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    return held_and_loaded(2, 1, "Plain", 10.0, **options)


def mass_on_a_rigid_arm():
    """A column with its mass at the end of a rigid link, held by a yielding spring there."""
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, (x, y) in enumerate(((0.0, 0.0), (0.0, 4.0), (2.0, 4.5), (2.0, 4.5)), start=1):
        ops.node(node, x, y)
    ops.fix(1, 1, 1, 1)
    ops.fix(4, 1, 1, 1)
    ops.geomTransf("Linear", 1)
    ops.element("elasticBeamColumn", 1, 1, 2, 0.5, 3.0e4, 0.05, 1)
    ops.rigidLink("beam", 2, 3)
    ops.mass(2, 0.5, 0.5, 0.1)
    ops.mass(3, 1.0, 1.0, 0.4)
    return held_and_loaded(3, 4, "Transformation", 10.0, 0.0, 0.0)


def set_test(tolerance=TIGHT, iterations=ITERATIONS):
    ops.test("NormDispIncr", tolerance, iterations)


def prepare(monkeypatch=None):
    """Prepare the model in the domain; recovery steps may keep its test and fail at any cost."""
    if monkeypatch:
        monkeypatch.setattr(step_loop, "MEAN_ITERATIONS", 10_000)
        monkeypatch.setattr(step_loop, "set_test", lambda *_: set_test())
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    set_test()


def loop_of(integrator=NEWMARK, **replaced):
    given = {"contact_dt_s": None, "event_dt_s": None}
    loop = step_loop.StepLoop(None, AnalysisSettings(dt_s=DT_S, integrator=integrator, **given))
    for name, value in replaced.items():
        setattr(loop, name, value)
    loop.start()
    return loop


@pytest.fixture
def oscillator(monkeypatch):
    spring_and_mass(spring=("Elastic", 1, 100.0))
    prepare(monkeypatch)


@pytest.mark.usefixtures("oscillator")
def test_a_successful_recovery_step_is_kept_for_some_steps(monkeypatch):
    strict = RecoveryStep(algorithm=("Newton",))
    loose = RecoveryStep(algorithm=("Newton",), tolerance_j=1e3)
    tested = []

    def use_test(_settings, _size_s, step):
        tested.append(step)
        set_test(TIGHT if step is loose or loose in tested else -1.0, 5)

    monkeypatch.setattr(step_loop, "set_test", use_test)
    loop = loop_of(recovery_steps=(strict, loose))
    assert len(list(loop.committed(step_loop.HELD_STEPS))) == step_loop.HELD_STEPS
    # one failure, and no other: the loose test is kept
    assert list(dict.fromkeys(tested)) == [strict, loose]
    assert tested[-1] is loose
    assert list(loop.committed(1)) == [DT_S]
    assert tested[-1] is strict
    assert (loop.effort.failures, loop.effort.highest_rung) == (1, 1)


@pytest.mark.usefixtures("oscillator")
def test_parts_of_several_lengths_fill_the_regular_step():
    announced, least_given, wanted = [], [], iter((2, 0, 3, 1, 0))

    def halvings(least):
        least_given.append(least)
        return max(least, next(wanted))

    loop = loop_of(HHT, halvings=halvings, prepare=announced.append)
    # a quarter, then the next quarter although more was allowed, an eighth, its like, a quarter
    assert list(loop.committed(1)) == [DT_S / 4, DT_S / 4, DT_S / 8, DT_S / 8, DT_S / 4]
    assert announced == [DT_S / 4, DT_S / 8, DT_S / 4]
    assert least_given == [0, 2, 1, 3, 2]
    assert ops.getTime() == pytest.approx(DT_S, rel=1e-12)
    assert (loop.effort.substeps, loop.effort.highest_rung) == (5, 0)


@pytest.mark.usefixtures("oscillator")
def test_the_finest_step_of_the_settings_is_possible_and_every_recovery_step_divides_the_finest():
    parts = [step.substeps for step in RECOVERY_STEPS]
    assert not any(parts[-1] % each for each in parts)
    assert parts == sorted(parts)
    finest = AnalysisSettings(dt_s=0.02, contact_dt_s=0.02, event_dt_s=1e-5).event_halvings
    assert finest <= step_loop.MAX_HALVINGS
    assert len(list(loop_of(halvings=lambda least: max(least, finest)).committed(1))) == 2**finest
    assert ops.getTime() == pytest.approx(DT_S)


# --- whole histories with failures
# Solutions that fail, by step, counted in the step: 0 to 2 are the recovery steps without
# sub-steps, from 3 on come the sub-steps of the finer ones.
PATHS = {
    "next recovery step": {40: {0}}, "last one without sub-steps": {40: {0, 1}},
    "all of its sub-steps": {40: {0, 1, 2}},
    "some sub-steps, the rest by the next": {40: {0, 1, 2, 4}},
    "some sub-steps, the rest finer": {40: {0, 1, 2, 4, 6}},
    "some sub-steps, the rest by the finest": {40: {0, 1, 2, 4, 6, 9}},
    "again while one is kept": {40: {0}, 45: {0}, 50: {0, 1}},
    "finer while one is kept": {40: {0}, 45: {0, 1, 2}},
    "after one was kept": {40: {0}, 40 + step_loop.HELD_STEPS + 3: {0, 1, 2, 3}},
    "two steps in a row": {40: {0, 1, 2}, 41: {0, 1, 2}}, "the first step": {0: {0}, 1: {0, 1, 2}},
    "many": {number: {0, 1, 2} if number % 2 else {0} for number in range(10, 100, 15)},
}  # fmt: skip
#: Solutions that fail in two steps that are made in four parts.
IN_PARTS = ({0}, {0, 1, 2}, {2}, {1, 2, 3, 5}, {2, 3, 4, 6, 8})
of_models = pytest.mark.parametrize("model", [spring_and_mass, mass_on_a_rigid_arm])
RULES = [HOUBOLT, HHT, NEWMARK, (*NEWMARK, "-form", "V")]
of_integrators = pytest.mark.parametrize("integrator", RULES)


class Failing:
    def __init__(self, monkeypatch, fails):
        self.fails, self.last, self.number = fails, 0, 0
        self.analyze, self.test = ops.analyze, ops.test
        monkeypatch.setattr(ops, "analyze", self.analyse)
        monkeypatch.setattr(ops, "test", self.set_test)

    def set_test(self, *given):
        self.given = given
        self.test(*given)

    def analyse(self, count, *step):
        fails = bool(step) and self.fails(self.number)
        self.number += 1
        if fails:
            self.test(self.given[0], -1.0, 2)
        self.last = int(self.analyze(count, *step))
        if fails:
            assert self.last != 0
            self.test(*self.given)
        return self.last

    def check(self):
        assert self.last == 0
        assert 0.0 <= ops.testNorms()[ops.testIter() - 1] <= self.given[1]
        return True


def driven(monkeypatch, model, integrator, failing, parts=lambda _: 1):
    """Make the steps; repeat one in which all recovery steps fail. Return the sizes of converged
    (sub-)steps, values after and results of the regular steps, and effort."""
    ops.wipe()
    node, sizes, values, ended = model(), [], [], []
    failures = Failing(monkeypatch, lambda n: n in failing.get(len(values), ()))
    prepare(monkeypatch)

    def halvings(fits):
        return max(fits, parts(len(values)).bit_length() - 1)

    loop = loop_of(integrator, halvings=halvings)
    while len(values) < STEPS:
        failures.number = 0
        try:
            for size_s in loop.committed(1):
                sizes.append(size_s)
                failures.check()
            ended.append(True)
            values.append(ops.nodeDisp(node, 1))
        except step_loop.NoConvergenceError:
            ended.append(False)
            failing = {}
    monkeypatch.undo()
    return sizes, values, ended, loop.effort


def plain(model, integrator, sizes):
    ops.wipe()
    node, values = model(), []
    prepare()
    ops.algorithm("Newton")
    ops.integrator(*integrator)
    ops.analysis("Transient", "-noWarnings")
    for size_s in sizes:
        assert ops.analyze(1, size_s) == 0
        if ops.getTime() > (len(values) + 1 - 1e-6) * DT_S:
            values.append(ops.nodeDisp(node, 1))
    return values


def assert_unchanged(values, model, integrator, sizes):
    """Compare with the same steps without failures, within the tolerance of the test. Houbolt loses
    its last two steps and restarts as the trapezoidal rule, at most seven times in these histories:
    2 %."""
    tolerance = 0.02 if integrator == HOUBOLT else 1e-8
    exact = plain(model, integrator, sizes)
    assert len(values) == len(exact) == STEPS
    assert np.abs(np.subtract(values, exact)).max() <= tolerance * np.abs(exact).max()


@of_models
@of_integrators
@pytest.mark.parametrize(
    ("failing", "parts"),
    [
        *((failing, lambda _: 1) for failing in PATHS.values()),
        *(({41: each, 73: each}, lambda n: 4 if n % 10 in (1, 2, 3) else 1) for each in IN_PARTS),
    ],
    ids=[*PATHS, *(f"parts {each}" for each in IN_PARTS)],
)
def test_failures_do_not_change_a_history(monkeypatch, failing, parts, integrator, model):
    sizes, values, ended, effort = driven(monkeypatch, model, integrator, failing, parts)
    assert all(ended)
    assert effort.failures == sum(map(len, failing.values()))
    assert sum(sizes) == pytest.approx(STEPS * DT_S, rel=1e-12)
    assert sum(effort.steps_by_rung.values()) == len(sizes)
    assert_unchanged(values, model, integrator, sizes)


@of_models
@of_integrators
@pytest.mark.parametrize("taken", [set(), {3}, {3, 5}, {3, 4, 5, 8}])
def test_a_failed_recovery_leaves_the_last_converged_state(monkeypatch, taken, integrator, model):
    """Some sub-steps converge before the recovery fails; the next call continues from there."""
    failing = {40: set(range(1000)) - taken}
    sizes, values, ended, effort = driven(monkeypatch, model, integrator, failing)
    assert ended.count(False) == 1
    assert effort.failures == len(RECOVERY_STEPS)
    assert effort.iterations >= MAX_ITERATIONS * len(RECOVERY_STEPS)
    assert len(sizes) == STEPS + len(taken)
    assert_unchanged(values, model, integrator, sizes)


def response(monkeypatch, failing):
    """Analyse OSB1 with some solutions made impossible: one iteration, no tolerance. No state is
    read that has not met its own test."""
    diverged = Watch.diverged
    failures = Failing(monkeypatch, lambda number: number + 1 in failing)
    monkeypatch.setattr(Watch, "diverged", lambda watch: failures.check() and diverged(watch))
    monkeypatch.setattr(step_loop.StepLoop, "recovery_steps", STRICT)
    # at this scale no column softens; after that, retries change the slip work by up to 4e-5
    result = analysed(variant(gap_mm=25), **SETTINGS, scale=0.75)
    monkeypatch.undo()
    return result


def test_a_retry_does_not_change_the_response(monkeypatch):
    smooth = response(monkeypatch, frozenset())
    rough = response(monkeypatch, FAILING)
    assert rough.effort.failures - smooth.effort.failures == len(FAILING)
    assert smooth.demands["contact_closures"] > 10
    assert not smooth.model_end.mode
    for name in ("column_drift_ratio", "deck_rotation_rad", "unseating_m", "slip_work_kj"):
        assert rough.demands[name] == pytest.approx(smooth.demands[name], rel=1e-8)


def few_iterations(count, steps=None):
    """Let the recovery steps fail after ``count`` iterations, with the first ``steps`` of them."""
    few = [replace(step, max_iterations=count) for step in RECOVERY_STEPS[:steps]]
    return patch.object(step_loop.StepLoop, "recovery_steps", few)


def assert_has_peaks(result):
    assert all(math.isfinite(v) for k, v in result.demands.items() if k not in ENERGY)
    assert result.demands["deck_disp_m"] > 0.0
    times = result.histories["t_s"]
    assert times[-1] == pytest.approx(result.time_reached_s)
    assert np.all(np.diff(times) > 0.0)


def assert_stopped(result, status, criterion=""):
    assert (result.status, result.collapse_criterion) == (status, criterion)
    assert 0.0 < result.time_reached_s < result.duration_s
    assert_has_peaks(result)


def test_a_collapse_stops_the_run_and_demands_are_those_until_a_column_fails():
    result = analysed(VARIANT, scale=4.0, dt_s=0.005)
    assert_stopped(result, "collapse", "column_drift_ratio")
    end, histories = result.model_end, result.histories
    assert end.mode == "flexure"
    until = histories["t_s"] <= end.time_s
    assert 0.0 < end.time_s < result.time_reached_s
    # histories are read at the regular steps, demands at all
    near = {"rel": 0.02}
    peaks = np.maximum(*(histories[f"column_{number}_drift_ratio"] for number in (1, 2)))
    assert peaks[until].max() == pytest.approx(result.demands["column_drift_ratio"], **near)
    assert peaks.max() > 2 * result.demands["column_drift_ratio"]  # the histories go on
    assert 0.10 <= peaks.max() < 0.12
    assert 1.0 <= result.demands["drift_over_capacity"] < 1.2
    shear = histories["column_shear_kn"][until].max()
    assert shear == pytest.approx(result.demands["column_shear_kn"], **near)


def test_limits_of_collapse_and_the_budget_of_iterations_end_an_analysis(monkeypatch):
    for demand, limits in {
        "deck_disp_m": {"collapse_deck_disp_m": 0.05},
        "column_drift_ratio": {"collapse_drift_ratio": 0.01},
    }.items():
        assert_stopped(analysed(VARIANT, duration_s=2.5, **limits), "collapse", demand)
    monkeypatch.setattr(step_loop, "MEAN_ITERATIONS", 1)
    assert_stopped(analysed(VARIANT, duration_s=2.5), "timeout")
    # an abutment alone has the same budget
    motion = Excitation(motion=strong_motion(duration_s=2.0))
    settings = AnalysisSettings(duration_s=1.0)
    history = abutment_history(VARIANT, motion, settings, ModelOptions())
    assert not history.is_complete
    assert history.t_s[-1] < 1.0


def test_failed_steps_are_recovered_and_logged_and_divergence_is_a_failure(tmp_path, monkeypatch):
    # Three iterations are too few for the steps in which contacts close.
    log = tmp_path / "opensees.log"
    with few_iterations(3):
        result = analysed(VARIANT, log_path=log, tolerance_j=1e-8, integrator=("Houbolt",))
    assert result.effort.highest_rung >= 1
    assert result.effort.failures > 2
    assert sum(result.effort.counts[1:]) > 2
    assert "failed" in log.read_text(encoding="utf-8")
    assert_has_peaks(result)
    # One percent of the bridge's weight at a contact represents the force of a lost solution.
    monkeypatch.setattr("skewbridge.analysis.transient.MAX_CONTACT_WEIGHTS", 0.01)
    result = analysed(VARIANT)
    assert_stopped(result, "numerical_failure")
    assert "the solution diverged: a contact carries" in result.messages[0]
    assert all(math.isnan(result.demands[name]) for name in ENERGY)
    names = [name for name in result.histories if name.endswith("_normal_kn")]
    assert max(result.histories[name].max() for name in names) < 0.01 * 19_500.0


def test_a_too_strict_tolerance_is_loosened_and_changes_no_later_analysis(capfd):
    clean = analysed(VARIANT, duration_s=1.0)
    with few_iterations(2):
        result = analysed(VARIANT, **TOO_STRICT)
    assert capfd.readouterr() == ("", ""), "OpenSees prints nothing"
    assert (result.status, result.effort.highest_rung) == ("ok", 2)
    assert result.effort.failures > 1
    assert recovery.loosened_share(recovery.steps_as_text(result.effort.counts)) > 0.0
    assert analysed(VARIANT, duration_s=1.0).demands == clean.demands
    # without further recovery steps it is a failure
    with few_iterations(2, steps=1):
        result = analysed(VARIANT, **TOO_STRICT)
    assert result.status == "numerical_failure"
    assert (result.messages[0], result.effort.failures) == ("no recovery step converged", 1)


def test_bad_factors_are_refused_and_histories_are_equally_spaced_to_the_end():
    for factors, words in (
        ({"scale": 0.0}, "scale must be a positive number, got 0"),
        ({"scale": -1.0}, "scale"),
        ({"scale": math.nan}, "scale"),
        ({"incidence_deg": math.inf}, "incidence_deg"),
        ({"scale": 1000.0}, "peak acceleration must be at most 1000 m/s2"),
    ):
        with pytest.raises(InputError, match=words):
            analysed(VARIANT, **factors)
    result = analysed(VARIANT, duration_s=2.0, free_vibration_s=0.5)
    assert (result.duration_s, result.time_reached_s) == (pytest.approx(2.5), pytest.approx(2.5))
    assert result.effort.substeps > 10
    assert np.diff(result.histories["t_s"]) == pytest.approx(AnalysisSettings().dt_s, rel=1e-6)
    openings = [name for name in result.histories if name.endswith("_opening_m")]
    assert min(result.histories[name].min() for name in openings) < 0.0
    quiet = result.histories["t_s"] > 2.01
    assert np.all(result.histories["ground_ax_mps2"][quiet] == 0.0)
    assert np.any(result.histories["ground_ax_mps2"][~quiet] != 0.0)

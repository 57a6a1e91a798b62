"""The recovery ladder: order, cost, sub-steps and what is held after a difficult step."""

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.recovery import HELD_STEPS, LADDER, MAX_HALVINGS, Attempt, Stepper
from skewbridge.analysis.settings import AnalysisSettings

DT_S = 0.01
STIFFNESS = 100.0


@pytest.fixture(autouse=True)
def clean_domain():
    ops.wipe()
    yield
    ops.wipe()


def build_oscillator(tolerance=1e-12, iterations=10):
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    ops.uniaxialMaterial("Elastic", 1, STIFFNESS)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 10.0)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", tolerance, iterations)


def stepper(integrator, ladder=LADDER, before=None, after=None, set_test=None, halvings=0):
    def continues(size):
        return after is None or after(size) is not False

    made = Stepper(
        integrator=integrator,
        dt_s=DT_S,
        halvings=lambda least: max(least, halvings),
        is_far=lambda: False,
        set_far=lambda _: None,
        set_test=set_test or (lambda _: None),
        max_iterations=10,
        before=before or (lambda _: None),
        after=continues,
        ladder=ladder,
    )
    ops.analysis("Transient", "-noWarnings")
    return made


def test_a_finer_rung_continues_where_the_coarser_one_stopped():
    build_oscillator()
    ladder = tuple(Attempt(algorithm=("Newton",), substeps=n) for n in (1, 4, 20))
    taken = []

    def before(size):
        ops.test("NormDispIncr", -1.0 if size == DT_S else 1e-12, 10)

    def after(size):
        taken.append(size)
        if size == DT_S / 4:  # the second quarter is impossible
            ops.test("NormDispIncr", -1.0, 2)

    steps = stepper(("Newmark", 0.5, 0.25), ladder, before, after)
    before(DT_S)
    assert steps.step()
    assert taken == [DT_S / 4] + [DT_S / 20] * 15
    assert ops.getTime() == pytest.approx(DT_S, rel=1e-12)
    assert (steps.effort.substeps, steps.effort.highest_rung) == (16, 2)


def test_an_unsolved_step_is_reported_with_its_cost():
    build_oscillator(tolerance=-1.0, iterations=2)
    steps = stepper(("Newmark", 0.5, 0.25))
    assert not steps.step()
    assert ops.getTime() == 0.0
    assert steps.effort.failed_attempts == len(LADDER)
    assert steps.effort.iterations == 10 * len(LADDER)


def test_every_rung_divides_the_finest():
    finest = LADDER[-1].substeps
    assert all(finest % attempt.substeps == 0 for attempt in LADDER)
    assert [a.substeps for a in LADDER] == sorted(a.substeps for a in LADDER)


def test_a_successful_rung_is_held_for_some_steps():
    build_oscillator()
    asked = []
    ladder = (
        Attempt(algorithm=("Newton",)),
        Attempt(algorithm=("Newton",), tolerance_j=1e3),
    )

    def set_test(attempt):
        asked.append(attempt.tolerance_j)
        ops.test("NormDispIncr", 1e-12 if asked[-1] > 0.0 or len(asked) > 2 else -1.0, 5)

    steps = stepper(("Newmark", 0.5, 0.25), ladder, set_test=set_test)
    set_test(ladder[0])
    assert all(steps.step() for _ in range(HELD_STEPS))
    assert asked == [0.0, 1e3]  # one failure, and no other: the loose test is still in force
    assert steps.step()
    assert asked == [0.0, 1e3, 0.0]
    assert steps.effort.failed_attempts == 1
    assert steps.effort.highest_rung == 1


def test_parts_of_several_lengths_fill_the_regular_step():
    build_oscillator()
    sizes, least_given, wanted = [], [], iter((2, 0, 3, 1, 0))

    def halvings(least):
        least_given.append(least)
        return max(least, next(wanted))

    steps = stepper(("HHT", 0.9), after=sizes.append)
    steps.halvings = halvings
    assert steps.step()
    # a quarter, then the next quarter although more was allowed, an eighth, its like, a quarter
    assert sizes == [DT_S / 4, DT_S / 4, DT_S / 8, DT_S / 8, DT_S / 4]
    assert least_given == [0, 2, 1, 3, 2]
    assert ops.getTime() == pytest.approx(DT_S, rel=1e-12)
    assert (steps.effort.substeps, steps.effort.highest_rung) == (5, 0)


def test_no_step_follows_the_end_of_a_history():
    build_oscillator()
    steps = stepper(("HHT", 0.9), after=lambda _: False, halvings=2)
    assert not steps.step()
    assert ops.getTime() == pytest.approx(DT_S / 4)


def test_a_change_of_the_step_size_is_announced():
    build_oscillator()
    announced = []
    steps = stepper(("HHT", 0.9), before=announced.append)
    assert steps.step()
    assert steps.step()
    steps.halvings = lambda least: max(least, 1)
    assert steps.step()
    assert announced == [DT_S, DT_S / 2]


def test_the_finest_step_of_the_settings_is_possible():
    finest = AnalysisSettings(dt_s=0.02, contact_dt_s=0.02, event_dt_s=1e-5).event_halvings
    assert finest <= MAX_HALVINGS
    build_oscillator()
    sizes = []
    assert stepper(("Newmark", 0.5, 0.25), after=sizes.append, halvings=finest).step()
    assert len(sizes) == 2**finest
    assert ops.getTime() == pytest.approx(DT_S)

"""Failed attempts at a step do not change the history, whichever rung of the ladder solves it.

Attempts fail after two iterations, so that their trial state is far from the committed one. The
reference is the same sequence of (sub-)steps without failures.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.recovery import HELD_STEPS, LADDER, Stepper

DT_S = 0.01
STEPS = 120
TIGHT, ITERATIONS = 1e-11, 30

# Attempts that fail, by step, counted in the step: 0 is rung 0, 1 and 2 are the rungs without
# sub-steps, from 3 on come the sub-steps of the finer rungs.
PATHS = {
    "next rung": {40: {0}},
    "last rung without sub-steps": {40: {0, 1}},
    "all of its sub-steps": {40: {0, 1, 2}},
    "some sub-steps, the rest on the next rung": {40: {0, 1, 2, 4}},
    "some sub-steps, the rest finer": {40: {0, 1, 2, 4, 6}},
    "some sub-steps, the rest on the finest": {40: {0, 1, 2, 4, 6, 9}},
    "again while a rung is held": {40: {0}, 45: {0}, 50: {0, 1}},
    "finer while a rung is held": {40: {0}, 45: {0, 1, 2}},
    "after a rung was held": {40: {0}, 40 + HELD_STEPS + 3: {0, 1, 2, 3}},
    "two steps one after the other": {40: {0, 1, 2}, 41: {0, 1, 2}},
    "the first step": {0: {0}, 1: {0, 1, 2}},
    "many": {number: {0, 1, 2} if number % 2 else {0} for number in range(10, 100, 15)},
}


@pytest.fixture(autouse=True)
def clean_domain() -> Iterator[None]:
    ops.wipe()
    yield
    ops.wipe()


def spring_and_mass() -> int:
    """A yielding spring with a mass, under a harmonic load; return the node to look at."""
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    ops.uniaxialMaterial("Steel01", 1, 8.0, 150.0, 0.1)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 10.0)
    ops.constraints("Plain")
    return 2


def mass_on_a_rigid_arm() -> int:
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
    ops.uniaxialMaterial("Steel01", 1, 8.0, 150.0, 0.1)
    ops.element("zeroLength", 2, 4, 3, "-mat", 1, "-dir", 1)
    ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
    ops.pattern("Plain", 1, 1)
    ops.load(3, 10.0, 0.0, 0.0)
    ops.constraints("Transformation")
    return 3


type Model = Callable[[], int]
MODELS: list[Model] = [spring_and_mass, mass_on_a_rigid_arm]
INTEGRATORS = [
    ("Houbolt",),
    ("HHT", 0.9),
    ("Newmark", 0.5, 0.25),
    ("Newmark", 0.5, 0.25, "-form", "V"),
]


@dataclass(kw_only=True)
class Driven:
    """Record of a stepper with prescribed failures: sizes, values and results of its steps."""

    node: int
    sizes: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)  # after each regular step
    attempts: list[int] = field(default_factory=list)  # results of `analyze`, all in order

    def accept(self, size_s: float) -> bool:
        """Check that the attempt converged, by its result and by its test."""
        assert self.attempts[-1] == 0
        assert 0.0 <= ops.testNorms()[ops.testIter() - 1] <= TIGHT
        self.sizes.append(size_s)
        return True


def usual_test(_: object = None) -> None:
    ops.test("NormDispIncr", TIGHT, ITERATIONS)


def driven(
    monkeypatch: pytest.MonkeyPatch,
    model: Model,
    integrator: tuple,
    failing: dict[int, set[int]],
    parts: Callable[[int], int] = lambda _: 1,
) -> tuple[Driven, list[bool], Stepper]:
    """Make the steps by the ladder; repeat one in which all attempts fail."""
    ops.wipe()
    found = Driven(node=model())
    prepare()
    analyze, number, attempt = ops.analyze, 0, 0

    def sometimes(count: int, size_s: float) -> int:
        nonlocal attempt
        fails = attempt in failing.get(number, ())
        attempt += 1
        if fails:
            ops.test("NormDispIncr", -1.0, 2)
        found.attempts.append(int(analyze(count, size_s)))
        if fails:
            assert found.attempts[-1] != 0
            usual_test()
        return found.attempts[-1]

    monkeypatch.setattr(ops, "analyze", sometimes)
    stepper = Stepper(
        integrator=integrator,
        dt_s=DT_S,
        halvings=lambda fits: max(fits, parts(number).bit_length() - 1),
        is_far=lambda: False,
        set_far=lambda _: None,
        set_test=usual_test,
        max_iterations=ITERATIONS,
        before=lambda _: None,
        after=found.accept,
    )
    ops.analysis("Transient", "-noWarnings")
    ended = []
    while number < STEPS:
        attempt = 0
        ended.append(stepper.step())
        if ended[-1]:
            found.values.append(ops.nodeDisp(found.node, 1))
            number += 1
        else:
            failing = {}
    monkeypatch.undo()
    return found, ended, stepper


def prepare() -> None:
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    usual_test()


def plain(model: Model, integrator: tuple, sizes: list[float]) -> list[float]:
    """Make steps of given sizes without failures; return the values at the regular steps."""
    ops.wipe()
    node, values, number = model(), [], 1
    prepare()
    ops.algorithm("Newton")
    ops.integrator(*integrator)
    ops.analysis("Transient", "-noWarnings")
    for size_s in sizes:
        assert ops.analyze(1, size_s) == 0
        if ops.getTime() > (number - 1e-6) * DT_S:
            values.append(ops.nodeDisp(node, 1))
            number += 1
    return values


def error(found: list[float], exact: list[float]) -> float:
    """Largest difference over the largest value."""
    assert len(found) == len(exact) == STEPS
    pairs = zip(found, exact, strict=True)
    return max(abs(a - b) for a, b in pairs) / max(map(abs, exact))


def tolerance(integrator: tuple) -> float:
    """Tolerance of a history: for one-step methods that of the convergence test.

    Houbolt loses its last two steps and restarts as the trapezoidal rule, at most seven times in
    these histories.
    """
    return 0.02 if integrator == ("Houbolt",) else 1e-8


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("path", PATHS)
def test_failed_attempts_do_not_change_a_history(monkeypatch, path, integrator, model) -> None:
    found, ended, stepper = driven(monkeypatch, model, integrator, PATHS[path])
    assert all(ended)
    assert stepper.effort.failed_attempts == sum(map(len, PATHS[path].values()))
    assert sum(found.sizes) == pytest.approx(STEPS * DT_S, rel=1e-12)
    assert sum(stepper.effort.steps_by_rung.values()) == len(found.sizes)
    whole = plain(model, integrator, found.sizes)
    assert error(found.values, whole) <= tolerance(integrator)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("attempts", [{0}, {0, 1, 2}, {2}, {1, 2, 3, 5}, {2, 3, 4, 6, 8}])
def test_failed_attempts_do_not_change_a_history_with_substeps(
    monkeypatch, attempts, integrator, model
) -> None:
    """The failed attempts are among those of a step in four parts; so are steps without failure."""
    found, ended, _ = driven(
        monkeypatch,
        model,
        integrator,
        {41: attempts, 73: attempts},
        parts=lambda number: 4 if number % 10 in (1, 2, 3) else 1,
    )
    assert all(ended)
    whole = plain(model, integrator, found.sizes)
    assert error(found.values, whole) <= tolerance(integrator)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("taken", [set(), {3}, {3, 5}, {3, 4, 5, 8}])
def test_a_failed_ladder_leaves_the_last_converged_state(
    monkeypatch, taken, integrator, model
) -> None:
    """Some sub-steps converge before the ladder fails; the next call continues from there."""
    failing = {40: set(range(1000)) - taken}
    found, ended, stepper = driven(monkeypatch, model, integrator, failing)
    assert ended.count(False) == 1
    assert stepper.effort.failed_attempts == len(LADDER)
    assert len(found.sizes) == STEPS + len(taken)
    whole = plain(model, integrator, found.sizes)
    assert error(found.values, whole) <= tolerance(integrator)


@pytest.mark.parametrize("model", MODELS)
def test_houbolt_survives_a_change_of_the_step(model) -> None:
    """It restarts as the trapezoidal rule, which is the more accurate of the two."""
    exact = plain(model, ("Newmark", 0.5, 0.25), [DT_S / 20] * 20 * STEPS)
    even = plain(model, ("Houbolt",), [DT_S] * STEPS)
    parts = [DT_S / 4] * 4
    uneven = plain(model, ("Houbolt",), [*[DT_S] * 5, *parts, DT_S, *parts] * (STEPS // 8))
    assert error(uneven, exact) <= error(even, exact)

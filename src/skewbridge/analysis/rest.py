"""Where the columns come to rest after a history: its last state, released and strongly damped.

Free vibration and not a static release: open gaps and slipping contacts leave nodes without
stiffness, which inertia holds, and a state in motion is no equilibrium to start from.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import hypot, nan, pi
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import configure_solver
from skewbridge.bridge.handles import BridgeModel
from skewbridge.contact import ContactError, ContactSet

STEPS_PER_PERIOD: Final = 20
MAX_PERIODS: Final = 10
#: As the motion fades, so must what a step may leave over: 1e-3 J would move the drift by 15 %.
TOLERANCE_J: Final = 1.0e-6
#: A column is at rest if its drift changes by less than this in a quarter of a period.
STILL_DRIFT: Final = 1.0e-5
_STEPS_STILL: Final = STEPS_PER_PERIOD // 4
# Newmark's gamma and beta that leave no high mode of penalties: the way to rest does not matter,
# only that it is short.
_INTEGRATOR: Final = ("Newmark", 1.0, 0.5625)
_PARTS: Final = (1, 4, 16)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """The columns at rest.

    Attributes:
        drifts: Resultant drift since gravity of every column over its clear height, of the model's
            columns in order; NaN where no rest was found.
        steps: Steps that it took.
        reason: Why no rest was found, or empty.
    """

    drifts: tuple[float, ...]
    steps: int
    reason: str = ""


def drifts_at_rest(
    model: BridgeModel,
    settings: AnalysisSettings,
    under_gravity_m: Callable[[int], tuple[float, float]],
) -> Rest:
    """Let the model in the open domain come to rest from its last state.

    It vibrates freely with critical damping on the masses of deck and columns at the bridge's long
    period, with the velocities it had and the contacts updated as before, until no column moves.
    The state of the history is lost.

    Args:
        model: Model after the last step of a history, whose motion has ended.
        settings: Those of the history.
        under_gravity_m: Plan displacement of a node under gravity, from which drifts count.
    """
    period_s = model.bridge.damping.long_period_s
    # ASSUME the path to rest adds no plastic drift: critical damping leaves no cycles
    factors = (4 * pi / period_s, 0.0, 0.0, 0.0)
    ops.region(model.tags.region(), "-ele", *model.damping_elements, "-rayleigh", *factors)
    configure_solver(settings)
    ops.test("EnergyIncr", min(settings.tolerance_j, TOLERANCE_J), settings.max_iterations)
    ops.algorithm("Newton")
    _forget_accelerations()
    ops.integrator(*_INTEGRATOR)
    ops.analysis("Transient", "-noWarnings")
    start = {
        node: under_gravity_m(node)
        for column in model.columns
        for node in (column.top_node, column.base_node)
    }
    read = partial(_drifts, model, start)
    trail = [read()]
    nothing = (nan,) * len(model.columns)
    for step in range(1, MAX_PERIODS * STEPS_PER_PERIOD + 1):
        try:
            moved = _advance(model.contacts, period_s / STEPS_PER_PERIOD)
        except ContactError as error:
            return Rest(drifts=nothing, steps=step, reason=str(error))
        if not moved:
            return Rest(drifts=nothing, steps=step, reason="a step on the way did not converge")
        trail.append(read())
        if step > _STEPS_STILL and _is_still(trail[-_STEPS_STILL - 1 :]):
            return Rest(drifts=trail[-1], steps=step)
    return Rest(drifts=nothing, steps=len(trail) - 1, reason=f"moving after {MAX_PERIODS} periods")


def _forget_accelerations() -> None:
    """Set the accelerations of what has no mass to zero.

    Under the trapezoidal rule they are not in equilibrium with anything and ring from step to step
    without being used; the integrator to rest would take them for motion.
    """
    for node in ops.getNodeTags():
        for dof in range(1, 7):
            if ops.nodeMass(node, dof) == 0.0:
                ops.setNodeAccel(node, dof, 0.0, "-commit")


def _advance(contacts: ContactSet | None, dt_s: float) -> bool:
    """Take one step, in parts if it does not converge as a whole."""
    for parts in _PARTS:
        part_s = dt_s / parts
        if contacts is not None:
            contacts.prepare(part_s)
        done = 0
        while done < parts and ops.analyze(1, part_s) == 0:
            done += 1
            if contacts is not None:
                contacts.after_step(part_s)
        if done == parts:
            return True
        dt_s -= done * part_s
        ops.domainChange()  # the equations keep what a failed attempt left behind
    return False


def _drifts(model: BridgeModel, start: dict[int, tuple[float, float]]) -> tuple[float, ...]:
    found: list[float] = []
    for column in model.columns:
        top, base = (
            [a - b for a, b in zip(ops.nodeDisp(node)[:2], start[node], strict=True)]
            for node in (column.top_node, column.base_node)
        )
        found.append(hypot(top[0] - base[0], top[1] - base[1]) / column.clear_height_m)
    return tuple(found)


def _is_still(trail: list[tuple[float, ...]]) -> bool:
    return all(max(drift) - min(drift) < STILL_DRIFT for drift in zip(*trail, strict=True))

"""Static pushover of a bridge, or of one abutment with the deck end that it supports."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, radians, sin
from os import devnull

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.trace import Series
from skewbridge.bridge.assembly import open_linear_pattern
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, build_abutment, domain
from skewbridge.bridge.plan import PlanVector
from skewbridge.bridge.springs import elastic_material, grounded_node
from skewbridge.contact import ContactSet
from skewbridge.contact.element import ContactError
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

# A failed step is tried with each algorithm in turn, then halved.
_ALGORITHMS = (("KrylovNewton",), ("NewtonLineSearch",), ("Newton", "-initial"))
_MAX_HALVINGS = 10
_MAX_ITERATIONS = 50
_TOLERANCE_M = 1.0e-9
_LAST_PART = 1.0e-12
_MAX_DISP_M = 5.0
_MAX_STEPS = 100_000
# Displacements are read on the pushed side of this spring, so it does not soften the curve.
_GUIDE_N_PER_M = 1.0e12


@dataclass(frozen=True, slots=True, kw_only=True)
class PushCurve:
    """Force and displacement along the push direction, both starting at zero, shape (n,)."""

    disp_m: Series
    force_n: Series
    is_complete: bool  # the target was reached

    @property
    def peak_n(self) -> float:
        """Largest force."""
        return float(self.force_n.max())

    @property
    def disp_at_peak_m(self) -> float:
        """Displacement at the largest force."""
        return float(self.disp_m[int(self.force_n.argmax())])

    @property
    def initial_stiffness_n_per_m(self) -> float:
        """Secant stiffness of the first step."""
        return float(self.force_n[1] / self.disp_m[1])


def push_bridge(
    variant: Variant,
    options: ModelOptions,
    *,
    angle_deg: float,
    max_disp_m: float,
    steps: int = 200,
) -> PushCurve:
    """Push the deck with forces proportional to its masses, at an angle counter-clockwise from x.

    Returns base shear and displacement of the mass centre along the push.
    """
    direction = _direction(angle_deg, max_disp_m, steps)
    with domain():
        model = build(variant, options)
        open_linear_pattern(model.tags)
        total = sum(model.frame.loads.masses_kg.values())
        for node, mass in model.frame.loads.masses_kg.items():
            share = mass / total
            ops.load(node, share * direction[0], share * direction[1], 0.0, 0.0, 0.0, 0.0)
        start = _along(model.frame.centre_node, direction)

        def read() -> tuple[float, float]:
            # unit loads: the load factor is the base shear
            return _along(model.frame.centre_node, direction) - start, float(ops.getTime())

        control = int(abs(direction[0]) < abs(direction[1]))  # the larger component
        integrator = ("DisplacementControl", model.frame.centre_node, control + 1)
        return _march(model.contacts, max_disp_m * direction[control], steps, read, integrator)


def push_abutment(
    variant: Variant,
    options: ModelOptions,
    *,
    angle_deg: float,
    max_disp_m: float,
    steps: int = 200,
) -> PushCurve:
    """Push one abutment (the right one) by its deck end, without the bridge.

    The deck end carries its dead-load reaction and moves only along the push: 0 degrees into the
    backfill along the bridge, 180 away from it; at the angle of the skew the push is normal to the
    wall. Returns guide force and displacement.
    """
    direction = _direction(angle_deg, max_disp_m, steps)
    with domain():
        ties: list[tuple[int, int]] = []
        abutment = build_abutment(
            variant, options, guide=lambda node, tags: ties.append(_tie(node, direction, tags))
        )
        ((tie, driver),) = ties
        open_linear_pattern(abutment.blueprint.tags)
        for dof, component in enumerate(direction, start=1):
            # the driver moves one metre per unit of time
            ops.remove("sp", driver, dof)
            ops.sp(driver, dof, component)
        start = _along(abutment.connector, direction)

        def read() -> tuple[float, float]:
            disp_m = _along(abutment.connector, direction) - start
            return disp_m, float(ops.basicForce(tie)[0])

        return _march(abutment.blueprint.contacts, max_disp_m, steps, read, ("LoadControl",))


def _tie(connector: int, direction: PlanVector, tags: TagAllocator) -> tuple[int, int]:
    """Tie the connector to a new fixed node; return tags of tie (axis 1 along push) and node."""
    driver, element = grounded_node(ops.nodeCoord(connector), tags), tags.element()
    stiff = elastic_material(_GUIDE_N_PER_M, tags)
    axes = (*direction, 0.0, -direction[1], direction[0], 0.0)
    springs = ("-mat", stiff, stiff, "-dir", 1, 2, "-orient", *axes)
    ops.element("zeroLength", element, connector, driver, *springs)
    return element, driver


def _march(
    contacts: ContactSet | None,
    target: float,
    steps: int,
    read: Callable[[], tuple[float, float]],
    integrator: tuple[str | int, ...],
) -> PushCurve:
    """Advance to a target, halving failed steps; return displacements and forces of `read`."""
    ops.logFile(devnull, "-noEcho")  # failed steps are repeated: their messages would mislead
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", _TOLERANCE_M, _MAX_ITERATIONS)
    ops.algorithm(*_ALGORITHMS[0])
    ops.integrator(*integrator, target / steps)
    ops.analysis("Static", "-noWarnings")
    rows = [(0.0, 0.0)]
    remaining, halvings = 1.0, 0
    while remaining > _LAST_PART and halvings <= _MAX_HALVINGS:
        share = min(0.5**halvings / steps, remaining)
        if contacts is not None:
            contacts.prepare(share)
        if not _converges(integrator, target * share):
            halvings += 1
            continue
        if contacts is not None:
            try:
                contacts.after_step(share)
            except ContactError:  # a mechanism: displacements are too large for double precision
                break
        remaining -= share
        halvings = max(halvings - 1, 0)
        rows.append(read())
    disp_m, force_n = np.array(rows).T
    return PushCurve(disp_m=disp_m, force_n=force_n, is_complete=remaining <= _LAST_PART)


def _converges(integrator: tuple[str | int, ...], increment: float) -> bool:
    for algorithm in _ALGORITHMS:
        ops.algorithm(*algorithm)
        ops.integrator(*integrator, increment)
        if ops.analyze(1) == 0:
            return True
        ops.domainChange()  # discard the state that a failed step left in the equations
    return False


def _along(node: int, direction: PlanVector) -> float:
    return float(ops.nodeDisp(node, 1) * direction[0] + ops.nodeDisp(node, 2) * direction[1])


def _direction(angle_deg: float, max_disp_m: float, steps: int) -> PlanVector:
    """Return the unit vector of a push; `InputError` if an argument is outside its range."""
    if not 0.0 < max_disp_m <= _MAX_DISP_M:
        raise InputError(f"max_disp_m must be within 0..{_MAX_DISP_M:g}, got {max_disp_m:g}")
    if not 2 <= steps <= _MAX_STEPS:
        raise InputError(f"steps must be within 2..{_MAX_STEPS}, got {steps}")
    return cos(radians(angle_deg)), sin(radians(angle_deg))

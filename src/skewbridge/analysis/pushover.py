"""Static pushover of a bridge, or of one abutment with the deck end that it supports.

Bridges with friction are pushed by a lever: a constraint that moves one driver node by the mean
displacement of the masses, so that every mass gets its share of the force. The lever is also used
if the push of a bridge with contacts would stop early: `DisplacementControl` of OpenSees predicts
each retry from the tangents of the failed step, in which pads and contacts may be open, and often
does not recover.
"""

from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from math import cos, radians, sin
from os import devnull
from statistics import fmean
from typing import Any, Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.analysis.trace import Series
from skewbridge.bridge.assembly import open_linear_pattern
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, build_abutment, domain
from skewbridge.bridge.plan import PlanVector
from skewbridge.bridge.springs import elastic_material, grounded_node
from skewbridge.contact import ContactSet
from skewbridge.contact.element import ContactError, uniaxial
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

# A failed step is tried with each algorithm in turn, then halved.
_ALGORITHMS = (("KrylovNewton",), ("NewtonLineSearch",), ("Newton", "-initial"))
_MAX_HALVINGS = 10
_MAX_ITERATIONS = 50
_TOLERANCE_M = 1.0e-9
_MAX_DISP_M = 5.0
_MAX_STEPS = 100_000
# Displacements are read on the pushed side of this spring, so it does not soften the curve.
_GUIDE_N_PER_M = 1.0e12

# --- pushes by a lever
_LEVER_ALGORITHMS: Final = (("KrylovNewton",), ("NewtonLineSearch",), ("Newton",))
#: Largest unbalanced force or moment of a step (N, N m).
_UNBALANCED: Final = 1.0
# Penalties (N/m) of supports, and of the lever and rigid links of scripts: at 10 MN, they yield by
# 0.01 and 0.1 um.
_PENALTIES: Final = (1.0e15, 1.0e14)
#: Largest |applied force - reactions| / force, and steps without displacement to reach it.
_IMBALANCE: Final = 5.0e-7
_CORRECTIONS: Final = 4
# Steps are halved at most this often where contacts change or the friction error is above the first
# value; they are doubled if it is below the second value.
_CONTACT_HALVINGS: Final = 6
_FRICTION_ERRORS: Final = 0.015, 0.003
# Stiffness of the brake / mass (1/s2): first values, least value and factor of its release. Walls
# and keys, which have no mass, have a share of the mass of the bridge.
_BRAKES: Final = (1.0e2, 1.0e4, 1.0e6)
_LEAST_BRAKE: Final = 1.0e-2
_SOFTER: Final = 8.0
_RELEASES: Final = 100
_LIGHT: Final = 0.01
_ROUNDING: Final = 1.0e-12
_REACHED: Final = 1.0e-6  # distance from the target / target
_MOST_PARTS: Final = 50  # mean number of parts of a step above which a push ends


@dataclass(frozen=True, slots=True, kw_only=True)
class PushCurve:
    """Force and displacement along the push direction, both starting at zero, shape (n,)."""

    disp_m: Series
    force_n: Series
    is_complete: bool  # the target was reached
    #: largest difference of the base shear from the applied force / largest base shear
    imbalance: float = 0.0
    #: mean displacement along the push of each deck between joints, in the last state
    decks_m: dict[str, float] = field(default_factory=dict[str, float])

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
    push = variant.normalised(), options, direction, max_disp_m, steps
    if push[0].friction == 0.0:
        curve = _push_mass_centre(*push)
        if curve.is_complete or not variant.traits.has_contacts:
            return curve
    # OpenSees keeps the equation of the lever when the domain is wiped, hence the own process
    loky: Any = import_module("joblib.externals.loky")  # by name, because it is untyped
    process = loky.ProcessPoolExecutor(max_workers=1)
    try:
        return process.submit(_push_by_lever, *push).result()
    finally:
        process.shutdown(kill_workers=True)  # no message of OpenSees at its exit


def _push_mass_centre(
    variant: Variant, options: ModelOptions, direction: PlanVector, max_disp_m: float, steps: int
) -> PushCurve:
    """Push a bridge by the displacement of its mass centre."""
    with domain():
        model = build(variant, options)
        open_linear_pattern(model.tags)
        total = sum(model.frame.loads.masses_kg.values())
        for node, mass in model.frame.loads.masses_kg.items():
            share = mass / total
            ops.load(node, share * direction[0], share * direction[1], 0.0, 0.0, 0.0, 0.0)
        start_m = _along(model.frame.centre_node, direction)

        def read() -> tuple[float, float]:
            # unit loads: the load factor is the base shear
            return _along(model.frame.centre_node, direction) - start_m, float(ops.getTime())

        control = int(abs(direction[0]) < abs(direction[1]))  # the larger component
        integrator = ("DisplacementControl", model.frame.centre_node, control + 1)
        push_m = max_disp_m, max_disp_m * direction[control]
        curve = _march(model.contacts, push_m, steps, read, integrator)
        return replace(curve, decks_m=_decks_m(model, direction))


class _Lever:
    """Lever that pushes the masses of a bridge; its driver moves one metre per unit of time."""

    def __init__(self, model: BridgeModel, direction: PlanVector) -> None:
        masses = model.frame.loads.masses_kg
        self._masses, self._centre, self._direction = [*masses], model.frame.centre_node, direction
        self._supports = [node for node in ops.getNodeTags() if ops.getFixedDOFs(node)]
        driver, total = grounded_node(ops.nodeCoord(self._centre), model.tags), sum(masses.values())
        terms = [
            (node, dof, share)
            for node, mass in masses.items()
            for dof, component in enumerate(direction, start=1)
            if abs(share := mass / total * component) > _ROUNDING  # OpenSees refuses zero
        ]
        # the driver moves by the mean, so the force on each mass is in proportion to it
        ops.equationConstraint(driver, 1, -1.0, *(value for term in terms for value in term))
        open_linear_pattern(model.tags)
        ops.remove("sp", driver, 1)
        ops.sp(driver, 1, 1.0)
        self._start = self._values()

    def read(self) -> tuple[float, float, float]:
        """Return displacement of the mass centre (m), base shear and applied force (N)."""
        disp_m, base_n, applied_n = np.subtract(self._values(), self._start).tolist()
        return disp_m, base_n, applied_n

    def _values(self) -> tuple[float, float, float]:
        ops.reactions()
        base_n = applied_n = 0.0
        for dof, component in enumerate(self._direction, start=1):
            for node in self._supports:
                if dof in ops.getFixedDOFs(node):
                    base_n -= component * ops.nodeReaction(node, dof)
            for node in self._masses:
                applied_n += component * ops.nodeReaction(node, dof)
        return _along(self._centre, self._direction), base_n, applied_n


class _Brake:
    """Temporary springs that hold masses, walls and keys near their last positions.

    They are used if the next equilibrium is far away. The model then creeps to it, as if in a
    viscous fluid.
    """

    def __init__(self, model: BridgeModel) -> None:
        masses, tags = model.frame.loads.masses_kg, model.tags
        small_mass_kg = _LIGHT * sum(masses.values())
        plane = [node for node in ops.getNodeTags() if ops.getFixedDOFs(node) == [3, 4, 5, 6]]
        self._springs: list[tuple[float, int]] = []  # kg, parameter of the stiffness
        self._offsets: list[tuple[int, int, float, int]] = []  # node, dof, start, parameter
        for node, mass_kg in {**masses, **dict.fromkeys(plane, small_mass_kg)}.items():
            ground, element = grounded_node(ops.nodeCoord(node), tags), tags.element()
            spring = uniaxial(tags, "Elastic", 0.0)
            materials = [uniaxial(tags, "InitStrainMaterial", spring, 0.0) for _ in range(2)]
            ops.element("zeroLength", element, ground, node, "-mat", *materials, "-dir", 1, 2)
            stiffness = tags.parameter()
            ops.parameter(stiffness, "element", element, "material", 1, "E")
            ops.addToParameter(stiffness, "element", element, "material", 2, "E")
            self._springs.append((mass_kg, stiffness))
            for dof in (1, 2):
                offset = tags.parameter()
                ops.parameter(offset, "element", element, "material", dof, "epsInit")
                # OpenSees measures deformation from creation
                self._offsets.append((node, dof, float(ops.nodeDisp(node, dof)), offset))

    def creeps(self, increment_m: float, contacts: ContactSet) -> bool:
        """Advance the lever against the brake springs, then soften them to zero in steps.

        Returns whether the model is in equilibrium without the springs.
        """
        values = iter(_BRAKES)
        brake_per_s2 = next(values)
        contacts.start_from_rest()
        while not self._moves(brake_per_s2, increment_m):
            if (brake_per_s2 := next(values, 0.0)) == 0.0:
                return False
        for _ in range(_RELEASES):
            contacts.start_from_rest()
            if brake_per_s2 == 0.0:
                return True
            brake_per_s2 = brake_per_s2 / _SOFTER if brake_per_s2 > _LEAST_BRAKE else 0.0
            if not self._moves(brake_per_s2, 0.0):
                brake_per_s2 = max(brake_per_s2, _LEAST_BRAKE) * _SOFTER**2
        return False

    def _moves(self, square: float, increment_m: float) -> bool:
        for node, dof, start_m, offset in self._offsets:
            ops.updateParameter(offset, start_m - float(ops.nodeDisp(node, dof)))
        for mass_kg, stiffness in self._springs:
            ops.updateParameter(stiffness, square * mass_kg)
        return _lever_moves(increment_m)


class _LeverSteps:
    """Sizes (m) of the parts of a push by a lever: shorter where contacts change or a part failed.

    A part of the least size that does not help repeatedly raises this size until the contacts are
    calm again.
    """

    def __init__(self, longest_m: float, contacts: ContactSet) -> None:
        self._contacts = contacts
        self._longest_m = self._size_m = longest_m
        self._least_m = self._shortest_m = longest_m / 2**_CONTACT_HALVINGS
        self._n_least = 0  # parts of the least size since the last regular step

    def next_m(self, remaining_m: float) -> float:
        """Return the size of the next part, which ends where a contact is about to change."""
        part_m = min(self._size_m, remaining_m)
        # the lever moves one metre per unit of time
        if (change_m := self._contacts.time_to_change_s()) < part_m:
            part_m = max(change_m, min(self._least_m, remaining_m))
        return part_m

    def halves(self, part_m: float) -> bool:
        """Halve the size after a part that failed; return whether it was not the shortest one."""
        if part_m <= self._shortest_m:
            return False
        self._size_m = 0.5 * part_m
        return True

    def adapt(self, part_m: float, changed: bool) -> None:
        """Set the next size after a part, from changes of contacts in it and its friction error."""
        if changed:
            self._size_m = self._least_m
        elif self._contacts.friction_error > _FRICTION_ERRORS[0]:
            self._size_m = max(0.5 * part_m, self._least_m)
        elif self._contacts.friction_error < _FRICTION_ERRORS[1]:
            self._size_m = min(2.0 * self._size_m, self._longest_m)
        self._n_least += self._size_m <= self._least_m
        if self._size_m == self._longest_m:
            self._least_m, self._n_least = self._shortest_m, 0
        elif self._n_least == 2**_CONTACT_HALVINGS:  # shorter parts do not help
            self._least_m, self._n_least = min(2.0 * self._least_m, self._longest_m), 0


def _push_by_lever(
    variant: Variant, options: ModelOptions, direction: PlanVector, max_disp_m: float, steps: int
) -> PushCurve:
    """Push a bridge with contacts by a `_Lever`."""
    ops.logFile(devnull, "-noEcho")  # new process: without messages of materials and failed steps
    with domain():
        model = build(variant, options)
        contacts, lever, brake = model.contacts, _Lever(model, direction), _Brake(model)
        assert contacts is not None
        test = "NormUnbalance", _UNBALANCED, _MAX_ITERATIONS // 2
        _start_analysis(("Penalty", *_PENALTIES), "UmfPack", test, ("LoadControl", 0.0))
        sizes, rows = _LeverSteps(max_disp_m / steps, contacts), [(0.0, 0.0, 0.0)]
        remaining_m, driven_m = max_disp_m, 0.0
        for _ in range(_MOST_PARTS * steps):
            if remaining_m <= _REACHED * max_disp_m:
                break
            part_m = sizes.next_m(remaining_m)
            contacts.prepare(part_m)
            if _lever_moves(part_m):
                row = _balanced(lever)
                try:
                    changed = contacts.after_step(part_m)
                except ContactError:  # a mechanism: displacements too large for double precision
                    break
            elif sizes.halves(part_m):
                continue
            elif changed := brake.creeps(part_m, contacts):
                row = _balanced(lever)
            else:
                break
            driven_m += part_m
            if _is_balanced(row):  # otherwise the next step starts from here, without a row
                rows.append(row)
                remaining_m, advance_m = max_disp_m - row[0], row[0] - rows[-2][0]
                # the mass centre moves less or more than the mean, which the lever drives
                remaining_m *= driven_m / advance_m if advance_m > 0.0 else 1.0
                driven_m = 0.0
            sizes.adapt(part_m, changed)
        decks_m = _decks_m(model, direction)
    disp_m, base_n, applied_n = np.array(rows).T
    return PushCurve(
        disp_m=disp_m,
        force_n=base_n,
        is_complete=remaining_m <= _REACHED * max_disp_m,
        imbalance=float(np.abs(applied_n - base_n).max() / np.abs(base_n).max()),
        decks_m=decks_m,
    )


def _decks_m(model: BridgeModel, direction: PlanVector) -> dict[str, float]:
    """Return the mean displacement (m) of the masses of each deck along a direction."""
    joints_m = [
        fmean(ops.nodeCoord(point.node, 1) for pad in joint.pads for point in pad)
        for joint in model.joints
    ]
    supports = ["left end", *(joint.name for joint in model.joints), "right end"]
    decks: dict[str, list[float]] = {}
    for node in model.frame.loads.masses_kg:
        start, end = supports[bisect(joints_m, ops.nodeCoord(node, 1)) :][:2]
        decks.setdefault(f"{start} to {end}", []).append(_along(node, direction))
    return {name: fmean(disps_m) for name, disps_m in decks.items()}


def _balanced(lever: _Lever) -> tuple[float, float, float]:
    """Return displacement and forces, after corrections if an algorithm stopped out of balance."""
    row = lever.read()
    for _ in range(_CORRECTIONS):
        if _is_balanced(row) or not _lever_moves(0.0):
            break
        row = lever.read()
    return row


def _is_balanced(row: tuple[float, float, float]) -> bool:
    _, base_n, applied_n = row
    return abs(applied_n - base_n) <= max(_IMBALANCE * abs(base_n), _UNBALANCED)


def _lever_moves(increment_m: float) -> bool:
    return _converges(_LEVER_ALGORITHMS, ("LoadControl",), increment_m)


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
        start_m = _along(abutment.connector, direction)

        def read() -> tuple[float, float]:
            disp_m = _along(abutment.connector, direction) - start_m
            return disp_m, float(ops.basicForce(tie)[0])

        push_m = max_disp_m, max_disp_m
        return _march(abutment.blueprint.contacts, push_m, steps, read, ("LoadControl",))


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
    push_m: tuple[float, float],
    steps: int,
    read: Callable[[], tuple[float, float]],
    integrator: tuple[str | int, ...],
) -> PushCurve:
    """Push along a direction, halving failed steps; return what `read` gives.

    ``push_m``: final displacement along the push, and its component that `integrator` controls.
    The control moves as much as the last step needed, because a deck also moves across the push.
    """
    ops.logFile(devnull, "-noEcho")  # failed steps are repeated: their messages would mislead
    test = "NormDispIncr", _TOLERANCE_M, _MAX_ITERATIONS
    target_m, control_m = push_m
    _start_analysis(("Transformation",), "BandGeneral", test, (*integrator, control_m / steps))
    rows = [(0.0, 0.0)]
    remaining, halvings, rate = 1.0, 0, 1.0
    for _ in range(_MOST_PARTS * steps):
        if remaining <= _REACHED or halvings > _MAX_HALVINGS:
            break
        step_share = min(0.5**halvings / steps, remaining)
        if contacts is not None:
            contacts.prepare(step_share)
        if not _converges(_ALGORITHMS, integrator, control_m * step_share * rate):
            halvings += 1
            continue
        if contacts is not None:
            try:
                contacts.after_step(step_share)
            except ContactError:  # a mechanism: displacements are too large for double precision
                break
        halvings = max(halvings - 1, 0)
        rows.append(read())
        if integrator[0] == "LoadControl":  # the driver moves along the push
            remaining -= step_share
            continue
        remaining = 1.0 - rows[-1][0] / target_m
        if (advance := (rows[-1][0] - rows[-2][0]) / target_m) > 0.0:
            rate *= step_share / advance
    disp_m, force_n = np.array(rows).T
    return PushCurve(disp_m=disp_m, force_n=force_n, is_complete=remaining <= _REACHED)


def _start_analysis(
    constraints: Sequence[Any], system: str, test: Sequence[Any], integrator: Sequence[Any]
) -> None:
    ops.constraints(*constraints)
    ops.numberer("RCM")
    ops.system(system)
    ops.test(*test)
    ops.algorithm(*_ALGORITHMS[0])
    ops.integrator(*integrator)
    ops.analysis("Static", "-noWarnings")


def _converges(
    algorithms: Sequence[tuple[str, ...]], integrator: tuple[str | int, ...], increment: float
) -> bool:
    """Try a step with each algorithm in turn; return whether one converged."""
    for algorithm in algorithms:
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

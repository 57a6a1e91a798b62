"""Contacts of a live OpenSees domain, updated once after each converged step."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import inf, sqrt
from typing import Final, get_args

import openseespy.opensees as ops

from skewbridge.contact.element import (
    Tags,
    TagSource,
    contact_frame,
    make_springs,
    prove_bounds_act,
    require_nodes,
)
from skewbridge.contact.law import ContactLaw, Coupling, Drive, Scheme, UnitLedger
from skewbridge.contact.unit import ComponentwiseUnit, ContactUnit, ElasticUnit
from skewbridge.errors import InputError

_UNIT_TYPES: Final[dict[str, type[ContactUnit]]] = {
    "vector": ContactUnit,
    "componentwise": ComponentwiseUnit,
    "elastic": ElasticUnit,
}
_SOFT: Final = 1e-9  # factor on friction springs that must not affect the modes
_MARGIN: Final = 1.001  # for rounding of a predicted opening


class ContactSet:
    """Contact pairs whose friction bounds are set by parameter updates.

    Args:
        tags: Source of unused tags; by default, tags above all tags in the live domain.
        update: If False, the friction springs never get strength. The model then has no friction,
            but the same elements and equations.
        scheme: `vector` tracks one vector stick point per pair; `componentwise` is the literal
            reading of the paper; `elastic` moves the stick point of elastic springs.
        coupling: `extrapolated` predicts normal force and slip direction at the end of the coming
            step; `lagged` uses their values at the beginning of the step (the paper).
    """

    units: list[ContactUnit]  #: in the order in which they were added
    changes: list[int]  #: indices of the units that opened or closed in the last step
    is_any_closed: bool
    least_opening_ratio: float  #: smallest opening / gap of all pairs; 0 for a pair without gap
    largest_normal_n: float
    #: Largest distance from the limit (sliding pairs) or excess (others) / force, last step.
    friction_error: float

    def __init__(
        self,
        tags: Tags | None = None,
        *,
        update: bool = True,
        scheme: Scheme = "vector",
        coupling: Coupling = "extrapolated",
    ) -> None:
        for field, value, kind in (("scheme", scheme, Scheme), ("coupling", coupling, Coupling)):
            choices = get_args(kind.__value__)
            if value not in choices:
                raise InputError(f"{field} must be one of {', '.join(choices)}, got {value!r}")
        self._tags: Tags = TagSource() if tags is None else tags
        self._is_updated = update
        self._unit_type = _UNIT_TYPES[scheme]
        self._is_extrapolated = coupling == "extrapolated"
        self.units = []
        self._driven: list[ContactUnit] = []
        self._dt_s = 0.0
        self._time_s = 0.0
        self._is_free = False
        self._survey()

    def add(
        self,
        node_i: int,
        node_j: int,
        normal: Sequence[float],
        gap_m: float,
        friction: float,
        cohesion_n: float = 0.0,
        *,
        kn: float,
        kt: float,
        tangent: Sequence[float] | None = None,
        drive: Drive | None = None,
        name: str = "",
    ) -> int:
        """Add a contact between two nodes of the domain and return the index of its unit.

        The pair closes when node j has moved by the gap against the normal. Only the relative
        displacement of the nodes counts, so they may be apart: with a positive gap, a pair
        is a node-to-line (2D) or node-to-surface (3D) contact. Displacements are measured from
        this call, so that a contact added to a deformed model starts with its full gap.

        Args:
            node_i: Node of the surface.
            node_j: Node of the body.
            normal: Outward normal of the surface, from i towards j; ndm components.
            gap_m: Initial gap.
            friction: Coulomb coefficient.
            cohesion_n: Friction limit at zero normal force, while closed.
            kn: Normal penalty in N/m.
            kt: Tangential penalty in N/m.
            tangent: First direction of the contact plane; horizontal by default.
            drive: User function that sets declared parameters after every step.
            name: Name in messages and in the ledger.

        Raises:
            InputError: A value is outside its limits, or the nodes cannot form a pair.
            ContactError: A parameter has no effect in this OpenSees build.
        """
        law = ContactLaw(kn, kt, friction, cohesion_n, gap_m)
        ndm = int(ops.getNDM()[0]) if ops.getNDM() else 0
        frame = contact_frame(normal, tangent, ndm)
        nodes = (node_i, node_j)
        require_nodes(nodes, ndm)
        is_elastic = self._unit_type is ElasticUnit
        if not self.units and not is_elastic:
            prove_bounds_act(self._tags, nodes, frame)
        driven = drive.parameters if drive else ()
        springs = make_springs(self._tags, nodes, frame, law, driven, is_elastic=is_elastic)
        index = len(self.units)
        unit = self._unit_type(name or f"contact {index}", nodes, frame, law, springs, drive)
        if drive:
            self._driven.append(unit)
        self.units.append(unit)
        self._survey()
        return index

    def after_step(self, dt_s: float, next_dt_s: float | None = None) -> bool:
        """Read a converged step of ``dt_s`` and set the bounds of friction of the next one.

        Call it once per step; give ``next_dt_s`` if the next step differs. Returns whether a pair
        opened or closed in the step. Raises `ContactError` if a spring force disagrees with its
        law.
        """
        if not dt_s > 0.0:
            raise InputError(f"dt_s must be positive, got {dt_s}")
        self._dt_s = dt_s
        self._time_s += dt_s
        self._survey(dt_s)
        next_dt = dt_s if next_dt_s is None else next_dt_s
        for unit in self._driven:
            unit.apply_drive(next_dt, self._time_s)
        self._set_bounds(next_dt / dt_s if self._is_extrapolated else None)
        return bool(self.changes)

    def prepare(self, next_dt_s: float) -> None:
        """Recompute the bounds for a next step of different length.

        Call it before the retry of a failed step (OpenSees has returned to the committed state,
        which is also the state tracked here) and when the step length changes.
        """
        if self._is_extrapolated and self._dt_s > 0.0:
            self._set_bounds(next_dt_s / self._dt_s)

    def start_from_rest(self) -> None:
        """Treat the committed state as a state at rest, because a static stage has no velocity.

        Call it between a static and a transient stage. While the nodes of a pair then keep their
        velocities, its steps are static.
        """
        for unit in self.units:
            unit.rest()
        self._survey()
        self._set_bounds(None)

    def _set_bounds(self, ratio: float | None) -> None:
        """Set the bounds of all units (`ContactUnit.set_bounds`), unless they remain zero."""
        is_free = ratio is not None and (
            self.least_opening_ratio > 0.0 and _MARGIN * ratio < self._steps_to_change
        )
        if self._is_updated and not (is_free and self._is_free):
            for unit in self.units:
                unit.set_bounds(ratio)
        self._is_free = is_free

    def _survey(self, dt_s: float | None = None) -> None:
        """Read a step of ``dt_s`` from the springs if given, and find the extremes of all units."""
        is_any_closed, largest_normal_n, friction_error = False, 0.0, 0.0
        least_ratio = least_steps = inf
        self.changes = []
        for index, unit in enumerate(self.units):
            if dt_s is not None and unit.read(dt_s):
                self.changes.append(index)
            opening, before, gap = unit.opening, unit.opening_before, unit.gap_m
            opening_ratio = opening / gap if gap else 0.0
            if opening_ratio < least_ratio:
                least_ratio = opening_ratio
            if opening * (before - opening) > 0.0:
                steps = opening / (before - opening)
                if steps < least_steps:
                    least_steps = steps
            is_any_closed |= unit.closed
            if not unit.normal_n <= largest_normal_n:  # true for NaN
                largest_normal_n = unit.normal_n
            if unit.excess_ratio > friction_error:
                friction_error = unit.excess_ratio
        self.is_any_closed, self.least_opening_ratio = is_any_closed, least_ratio
        self.largest_normal_n, self.friction_error = largest_normal_n, friction_error
        self._steps_to_change = least_steps

    def time_to_change_s(self) -> float:
        """Return the time in s until a pair opens or closes at its last speed, else infinity."""
        return self._steps_to_change * self._dt_s if self._dt_s > 0.0 else inf

    def time_to_closing_s(self, accel_mps2: float) -> float:
        """Return the time in s until a pair closes under an acceleration; zero if one is closed."""
        shortest_s, dt_s = inf, self._dt_s
        for unit in self.units:
            if unit.opening <= 0.0 or not dt_s:
                return 0.0
            rate = (unit.opening - unit.opening_before) / dt_s
            time_s = (rate + sqrt(rate**2 + 2.0 * accel_mps2 * unit.opening)) / accel_mps2
            if time_s < shortest_s:
                shortest_s = time_s
        return shortest_s

    @property
    def openings_m(self) -> list[float]:
        """Opening of each pair in m, negative when closed."""
        return [unit.opening for unit in self.units]

    @property
    def normals_n(self) -> list[float]:
        """Compression of each pair in N."""
        return [unit.normal_n for unit in self.units]

    @property
    def tangentials_n(self) -> list[tuple[float, float]]:
        """Friction force (N) of each pair along t1 and t2, with the sign of slip."""
        return [(unit.force_1, unit.force_2) for unit in self.units]

    def global_force_on_j(self, unit: int) -> tuple[float, ...]:
        """Return the force of a unit on its node j along the axes of the model, in N."""
        pair = self.units[unit]
        forces = (pair.normal_n, -pair.force_1, -pair.force_2)
        # a plane model has one tangent
        terms = zip(forces, (pair.normal, *pair.tangents), strict=False)
        products = [[force_n * value for value in axis] for force_n, axis in terms]
        return tuple(map(sum, zip(*products, strict=True)))

    def ledger(self) -> list[UnitLedger]:
        """Return the `UnitLedger` of each unit, summed since the unit was added."""
        return [
            replace(unit.ledger, normal_potential_j=0.5 * unit.kn * min(unit.opening, 0.0) ** 2)
            for unit in self.units
        ]

    @contextmanager
    def soft_tangents(self) -> Generator[None]:
        """Make the friction springs soft inside a `with` block, around an eigenvalue analysis.

        `eigen` uses the full stiffness of a friction spring even if its strength is zero.
        """
        try:
            for unit in self.units:
                unit.scale_tangents(_SOFT)
            yield
        finally:
            for unit in self.units:
                unit.scale_tangents(1.0)


def make_step(contacts: ContactSet, dt_s: float, *, parts_on_change: int = 1) -> bool:
    """Make one step of the transient analysis, update the contacts, and return whether it is done.

    If not, domain and contacts are at the end of the last committed sub-step. A step in which a
    pair will open or close has ``parts_on_change`` sub-steps; in one step the accuracy would be an
    order lower. Only one-step integrators profit: Houbolt restarts when the step changes.
    """
    substeps = parts_on_change if contacts.time_to_change_s() < dt_s else 1
    substep_s = dt_s / substeps
    if substeps > 1:
        contacts.prepare(substep_s)
    for number in range(substeps):
        if ops.analyze(1, substep_s) != 0:
            return False
        contacts.after_step(substep_s, dt_s if number == substeps - 1 else substep_s)
    return True

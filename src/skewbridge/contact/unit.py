"""One contact unit of a live model: reads its springs, tracks the stick point, sets the bounds."""

from copy import copy
from dataclasses import dataclass
from math import hypot
from typing import Any, Final, Literal

import openseespy.opensees as ops

from skewbridge.contact.frame import Vector
from skewbridge.contact.law import ContactLaw, radial_return, yields_on_cone
from skewbridge.contact.ledger import Account
from skewbridge.contact.springs import ContactError, Springs

type Scheme = Literal["vector", "componentwise", "elastic"]
type Coupling = Literal["extrapolated", "lagged"]

# Force read back against force expected, relative: the springs are evaluated in double precision,
# and the largest loss is that of a small offset between large displacements.
FORCE_ROUNDING: Final = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitState:
    """State of a unit at the end of the last committed step.

    Attributes:
        is_closed: The pair is in compression.
        opening_m: Gap plus relative displacement along the normal, negative when closed.
        penetration_m: Negative opening, zero while open.
        normal_n: Compression.
        tangential_n: Friction forces along t1 and t2, with the sign of slip.
        slip_m: Stick point along t1 and t2 (the position itself while open).
        position_m: Relative tangential displacement along t1 and t2.
        slip_speed_mps: Speed of the stick point in the last step.
        approach_speed_mps: Closing speed at the last closing of the pair.
        time_s: Time since the set was made.
    """

    is_closed: bool
    opening_m: float
    penetration_m: float
    normal_n: float
    tangential_n: tuple[float, float]
    slip_m: tuple[float, float]
    position_m: tuple[float, float]
    slip_speed_mps: float
    approach_speed_mps: float
    time_s: float


def _tracked_slots(unit_type: type) -> list[str]:
    return [slot for base in unit_type.__mro__ for slot in getattr(base, "__slots__", ())]


class ContactUnit:
    """A node-to-node pair whose friction springs get their bounds from the tracked state.

    Made by `ContactSet.add`; what a caller may use are the attributes below.

    Attributes:
        name: Name given by the caller.
        node_i: Node of the surface.
        node_j: Node of the body.
        element: Tag of the zeroLength element.
        normal: Outward normal of the surface.
        tangents: One direction of the contact plane in plane models, two in space.
        gap_m: Initial gap.
    """

    __slots__ = (
        "_b1",
        "_b2",
        "_e1",
        "_e1_before",
        "_e2",
        "_e2_before",
        "_is_space",
        "_is_watched",
        "_opening_before",
        "_stick_1",
        "_stick_2",
        "account",
        "approach_speed",
        "closed",
        "cohesion",
        "element",
        "force_1",
        "force_2",
        "friction",
        "gap_m",
        "kn",
        "kt",
        "name",
        "node_i",
        "node_j",
        "normal",
        "normal_n",
        "opening",
        "slip_1",
        "slip_1_before",
        "slip_2",
        "slip_2_before",
        "slip_speed",
        "springs",
        "tangents",
    )

    def __init__(
        self,
        name: str,
        nodes: tuple[int, int],
        frame: tuple[Vector, ...],
        law: ContactLaw,
        springs: Springs,
    ) -> None:
        self.name, self.springs, self.element = name, springs, springs.element
        self.node_i, self.node_j = nodes
        self.normal, self.tangents = frame[0], frame[1:]
        self.gap_m = law.open_gap_m
        self.kn, self.kt = law.kn_n_per_m, law.kt_n_per_m
        self.friction, self.cohesion = law.friction, law.cohesion_n
        self.account = Account()
        self._is_space = len(frame) == 3
        self._is_watched = False
        self.closed = False
        self.opening = self._opening_before = law.open_gap_m
        self.normal_n = self.force_1 = self.force_2 = 0.0
        self._e1 = self._e2 = self._e1_before = self._e2_before = 0.0
        self._stick_1 = self._stick_2 = self.slip_1 = self.slip_2 = 0.0
        self.slip_1_before = self.slip_2_before = 0.0
        self._b1 = self._b2 = 0.0
        self.slip_speed = self.approach_speed = 0.0

    def read(self, dt_s: float) -> bool:
        """Take over the committed step; return whether the pair opened or closed in it."""
        deformation = ops.basicDeformation(self.element)
        opening = self.gap_m + deformation[0]
        self._opening_before, self.opening = self.opening, opening
        self._e1_before, self._e2_before = self._e1, self._e2
        self._e1 = deformation[1]
        if self._is_space:
            self._e2 = deformation[2]
        if opening >= 0.0 and not self._is_watched:
            # Open before and after: the springs are at rest and the stick point goes along.
            self._stick_1 = self.slip_1 = self._e1
            self._stick_2 = self.slip_2 = self._e2
            return False
        was_closed = self.closed
        self._read_forces(dt_s)
        self._move_stick_point()
        return self.closed != was_closed

    def _read_forces(self, dt_s: float) -> None:
        """Read the springs, keep the accounts and check that the bounds of the step acted."""
        forces = ops.basicForce(self.element)
        normal_before, force_1_before, force_2_before = self.normal_n, self.force_1, self.force_2
        force_1, normal = forces[1], -forces[0]
        force_2 = forces[2] if self._is_space else 0.0
        if self.springs.dashpot is not None:
            normal -= forces[-1]
        opening = self.opening
        closed = opening < 0.0
        self._check(-forces[0], force_1, force_2)
        slip_1, slip_2 = self._e1 - force_1 / self.kt, self._e2 - force_2 / self.kt
        moved_1, moved_2 = slip_1 - self.slip_1, slip_2 - self.slip_2
        account = self.account
        account.slip_work_j += 0.5 * (
            (force_1 + force_1_before) * moved_1 + (force_2 + force_2_before) * moved_2
        )
        account.normal_work_j += 0.5 * (normal + normal_before) * (self._opening_before - opening)
        size = hypot(force_1, force_2)
        if closed:
            account.contact_time_s += dt_s
            account.max_penetration_m = max(account.max_penetration_m, -opening)
            account.max_normal_n = max(account.max_normal_n, normal)
            account.max_friction_n = max(account.max_friction_n, size)
            limit = self.cohesion + self.friction * normal
            account.max_limit_n = max(account.max_limit_n, limit)
            account.max_violation_n = max(account.max_violation_n, size - limit)
            if not self.closed:
                account.closures += 1
                self.approach_speed = (self._opening_before - opening) / dt_s
        elif size > account.max_violation_n:
            account.max_violation_n = size
        self.slip_speed = hypot(moved_1, moved_2) / dt_s
        self.slip_1_before, self.slip_2_before = self.slip_1, self.slip_2
        self.slip_1, self.slip_2 = slip_1, slip_2
        self.force_1, self.force_2, self.normal_n, self.closed = force_1, force_2, normal, closed

    def _check(self, spring_n: float, force_1: float, force_2: float) -> None:
        """Compare the forces with the law: the run-time part of the proof."""
        expected = -self.kn * self.opening if self.opening < 0.0 else 0.0
        scale = self.kn * (abs(self.opening) + self.gap_m)
        if abs(spring_n - expected) > FORCE_ROUNDING * scale:
            msg = (
                f"contact {self.name!r} (element {self.element}): the normal spring gives "
                f"{spring_n:.6g} N where {expected:.6g} N was expected"
            )
            raise ContactError(msg)
        self._check_friction(force_1, force_2)

    def _check_friction(self, force_1: float, force_2: float) -> None:
        slack = FORCE_ROUNDING * self.kt * (abs(self._e1) + abs(self._e2))
        if abs(force_1) > self._b1 + slack or abs(force_2) > self._b2 + slack:
            msg = (
                f"contact {self.name!r} (element {self.element}): the friction springs give "
                f"({force_1:.6g}, {force_2:.6g}) N beyond their bounds "
                f"({self._b1:.6g}, {self._b2:.6g}) N; were the parameters removed?"
            )
            raise ContactError(msg)

    def _move_stick_point(self) -> None:
        """Bring the tracked vector stick point to the committed position and normal force."""
        if not self.closed:
            self._stick_1, self._stick_2 = self._e1, self._e2
            self._is_watched = False  # until bounds are set for the coming step
            return
        self._is_watched = True
        offset_1, offset_2 = self._e1 - self._stick_1, self._e2 - self._stick_2
        limit = max(0.0, self.cohesion + self.friction * self.normal_n)
        if self.kt * hypot(offset_1, offset_2) > limit:
            force_1, force_2 = radial_return(offset_1, offset_2, self.kt, limit)
            self._stick_1 = self._e1 - force_1 / self.kt
            self._stick_2 = self._e2 - force_2 / self.kt

    def rest(self) -> None:
        """Read the springs as they are and forget the motion that led there."""
        deformation = ops.basicDeformation(self.element)
        forces = ops.basicForce(self.element)
        self.opening = self._opening_before = self.gap_m + deformation[0]
        self._e1 = self._e1_before = deformation[1]
        self.normal_n, self.force_1 = -forces[0], forces[1]
        if self._is_space:
            self._e2 = self._e2_before = deformation[2]
            self.force_2 = forces[2]
        self.closed = self.opening < 0.0
        self.slip_1 = self._stick_1 = self._e1 - self.force_1 / self.kt
        self.slip_2 = self._stick_2 = self._e2 - self.force_2 / self.kt
        self._is_watched = self.closed

    def start(self) -> None:
        """Bring the springs into the state of an open pair; they are created without strength."""

    def normal_potential_j(self) -> float:
        """Return the energy stored in the normal spring."""
        return 0.5 * self.kn * self.opening**2 if self.opening < 0.0 else 0.0

    def scale_tangents(self, ratio: float) -> None:
        """Set the stiffness of the friction springs to `ratio` times their own."""
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, ratio * self.kt)

    def snapshot(self) -> dict[str, Any]:
        """Return everything that is tracked."""
        saved = {slot: getattr(self, slot) for slot in _tracked_slots(type(self))}
        return saved | {"account": copy(self.account)}

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to a snapshot and set its bounds again."""
        for slot, value in saved.items():
            setattr(self, slot, value)
        self.account = copy(self.account)
        for parameter, bound in zip(self.springs.bounds, (self._b1, self._b2), strict=False):
            ops.updateParameter(parameter, bound)

    def predicted_opening(self, ratio: float) -> float:
        """Return the opening expected after `ratio` times the last step, linear in time."""
        return self.opening + ratio * (self.opening - self._opening_before)

    def set_bounds(self, ratio: float | None) -> None:
        """Set the bounds of the coming step, `ratio` times as long as the last; None: lagged."""
        if ratio is None:
            limit = self.cohesion + self.friction * self.normal_n if self.closed else 0.0
            offset_1, offset_2 = self._e1 - self._stick_1, self._e2 - self._stick_2
        else:
            limit, offset_1, offset_2 = self._predict(ratio)
        if limit <= 0.0:
            self._update(0.0, 0.0)
        elif self._is_space:
            self._update(*yields_on_cone(self.kt * offset_1, self.kt * offset_2, limit))
        else:
            self._update(limit, 0.0)

    def _predict(self, ratio: float) -> tuple[float, float, float]:
        """Return friction limit and offset from the stick point at the end of the coming step."""
        opening = self.opening
        predicted = opening + ratio * (opening - self._opening_before)
        if predicted >= 0.0:
            return 0.0, 0.0, 0.0
        limit = self.cohesion - self.friction * self.kn * predicted
        # While the pair is open the stick point goes along: only the part after closing counts.
        share = ratio if opening <= 0.0 else ratio * predicted / (predicted - opening)
        offset_1 = self._e1 - self._stick_1 + share * (self._e1 - self._e1_before)
        offset_2 = self._e2 - self._stick_2 + share * (self._e2 - self._e2_before)
        return limit, offset_1, offset_2

    def _update(self, bound_1: float, bound_2: float) -> None:
        bounds = self.springs.bounds
        if bound_1 != self._b1:
            ops.updateParameter(bounds[0], bound_1)
            self._b1 = bound_1
        if bound_2 != self._b2:
            ops.updateParameter(bounds[1], bound_2)
            self._b2 = bound_2
        if bound_1 != 0.0 or bound_2 != 0.0:
            self._is_watched = True

    def state(self, time_s: float) -> UnitState:
        """Return the state at the end of the last committed step."""
        return UnitState(
            is_closed=self.closed,
            opening_m=self.opening,
            penetration_m=max(0.0, -self.opening),
            normal_n=self.normal_n,
            tangential_n=(self.force_1, self.force_2),
            slip_m=(self.slip_1, self.slip_2),
            position_m=(self._e1, self._e2),
            slip_speed_mps=self.slip_speed,
            approach_speed_mps=self.approach_speed,
            time_s=time_s,
        )

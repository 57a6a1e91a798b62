"""One contact unit: reads its springs, moves its stick point, sets the bounds of the next step.

`ContactUnit` tracks one vector stick point. The other two classes are schemes for comparison.

`read` and `set_bounds` run for every contact in every step of every response history. They use
plain floats, slots and as few calls as possible.
"""

from math import hypot
from typing import Final

import openseespy.opensees as ops

from skewbridge.contact.element import ContactError, Direction, Springs
from skewbridge.contact.law import (
    ContactLaw,
    Drive,
    UnitLedger,
    UnitState,
    friction_limit_n,
    radial_return,
    yields_by_direction,
    yields_on_cone,
)

# Relative tolerance of a spring force against the expected one. OpenSees uses double precision;
# most digits are lost in a small offset between large displacements.
FORCE_ROUNDING: Final = 1e-6
# A friction force below this share of the largest so far does negligible work: its excess over the
# limit, often rounding, does not justify shorter steps.
LEAST_FRICTION: Final = 0.01
# A friction spring slides if its force has reached this share of its bound, but for rounding.
SLIDING_SHARE: Final = 1.0 - 1e-6
# Step lengths that differ by a smaller ratio count as equal: rounding of the times.
SAME_STEP: Final = 1e-6


class ContactUnit:
    """A node-to-node pair with one tracked vector stick point (scheme `vector`).

    `ContactSet.add` creates it, from node i of the surface to node j of the body. The bounds of its
    friction springs follow from the tracked state. Suffixes 1 and 2 are the tangents (one in plane
    models): `_u` is displacement of j minus i, `_step` its last change, `_bend` the change of that.
    """

    __slots__ = (
        "_bend_1", "_bend_2", "_bound_1", "_bound_2", "_dt", "_has_forces", "_is_3d",
        "_slip_1_before", "_slip_2_before", "_step_1", "_step_2", "_stick_1", "_stick_2", "_u1",
        "_u2", "_velocities", "closed", "cohesion", "dashpot", "drive", "element", "excess_ratio",
        "force_1", "force_2", "friction", "gap_m", "kn", "kt", "ledger", "name", "node_i", "node_j",
        "normal", "normal_n", "opening", "opening_before", "slip_1", "slip_2", "slip_step",
        "springs", "tangents",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        nodes: tuple[int, int],
        frame: tuple[Direction, ...],
        law: ContactLaw,
        springs: Springs,
        drive: Drive | None = None,
    ) -> None:
        self.name, self.springs, self.element = name, springs, springs.element
        self.node_i, self.node_j = nodes
        self.normal, self.tangents = frame[0], frame[1:]
        self.gap_m = law.gap_m
        self.kn, self.kt = law.kn_n_per_m, law.kt_n_per_m
        self.friction, self.cohesion, self.dashpot = law.friction, law.cohesion_n, 0.0
        self.drive = drive
        self.ledger = UnitLedger(name)
        self._is_3d = len(frame) == 3
        self.closed = self._has_forces = False
        self.opening = self.opening_before = law.gap_m
        self.normal_n = self.force_1 = self.force_2 = 0.0
        self._u1 = self._u2 = self._step_1 = self._step_2 = self._bend_1 = self._bend_2 = 0.0
        self._stick_1 = self._stick_2 = self.slip_1 = self.slip_2 = 0.0
        self._slip_1_before = self._slip_2_before = self._bound_1 = self._bound_2 = 0.0
        self.slip_step = self._dt = self.excess_ratio = 0.0
        self._velocities = self._read_velocities()
        self.start()

    def start(self) -> None:
        """Put the springs in the open state; springs of this scheme are created in this state."""

    def state(self, dt_s: float) -> UnitState:
        """Return the state at the end of the last committed step, before a step of `dt_s`."""
        last_change_m = self.opening - self.opening_before
        return UnitState(
            opening_m=self.opening,
            opening_rate_mps=last_change_m / self._dt if self._dt else 0.0,
            normal_n=self.normal_n,
            tangential_n=(self.force_1, self.force_2),
            slip_m=(self.slip_1, self.slip_2),
            position_m=(self._u1, self._u2),
            slip_speed_mps=self.slip_step / self._dt if self._dt else 0.0,
            slip_path_m=self.ledger.slip_path_m,
            slip_work_j=self.ledger.slip_work_j,
            dt_s=dt_s,
        )

    def rest(self) -> None:
        """Read the springs and treat their state as at rest, so no motion is extrapolated."""
        deformation, forces = ops.basicDeformation(self.element), ops.basicForce(self.element)
        self.opening = self.opening_before = self.gap_m + deformation[0]
        self._u1 = deformation[1]
        self.normal_n, self.force_1 = -forces[0], forces[1]
        if self._is_3d:
            self._u2 = deformation[2]
            self.force_2 = forces[2]
        self._step_1 = self._step_2 = self._bend_1 = self._bend_2 = 0.0
        self.closed = self._has_forces = self.opening < 0.0
        self.slip_1 = self._stick_1 = self._u1 - self.force_1 / self.kt
        self.slip_2 = self._stick_2 = self._u2 - self.force_2 / self.kt
        self._velocities = self._read_velocities()

    def _read_velocities(self) -> tuple[float, ...]:
        return (*ops.nodeVel(self.node_i), *ops.nodeVel(self.node_j))

    def apply_drive(self, dt_s: float, time_s: float) -> None:
        """Call the user function and set its parameters for the coming step."""
        if self.drive is None:
            return
        values = self.drive.values(self.state(dt_s), time_s)
        self.friction = values.get("friction", self.friction)
        self.cohesion = values.get("cohesion_n", self.cohesion)
        if "kn_n_per_m" in values:
            self.kn = values["kn_n_per_m"]
            ops.updateParameter(self.springs.normal_modulus, self.kn)
        if "kt_n_per_m" in values:
            self.kt = values["kt_n_per_m"]
            self.scale_tangents(1.0)
        if "dashpot_n_s_per_m" in values and self.springs.dashpot is not None:
            self.dashpot = values["dashpot_n_s_per_m"]
            ops.updateParameter(self.springs.dashpot, self.dashpot)

    def scale_tangents(self, ratio: float) -> None:
        """Set the stiffness of the friction springs to `ratio` times the tangential penalty."""
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, ratio * self.kt)

    def read(self, dt_s: float) -> bool:
        """Read the committed step; return whether the pair opened or closed in it."""
        deformation = ops.basicDeformation(self.element)
        self.opening_before = self.opening
        self.opening = opening = self.gap_m + deformation[0]
        step_1, self._u1 = deformation[1] - self._u1, deformation[1]
        step_2 = 0.0
        if self._is_3d:
            step_2, self._u2 = deformation[2] - self._u2, deformation[2]
        if self._has_forces or opening <= 0.0:  # open pairs need no curvature
            self._bend_1 = self._bend_2 = 0.0
            if -SAME_STEP * dt_s < dt_s - self._dt < SAME_STEP * dt_s:
                self._bend_1, self._bend_2 = step_1 - self._step_1, step_2 - self._step_2
        self._step_1, self._step_2, self._dt = step_1, step_2, dt_s
        if self._has_forces or opening < 0.0:
            return self._read_forces(dt_s)
        # Open before and after: the springs are at rest and the stick point follows the node.
        self._stick_1 = self.slip_1 = self._u1
        self._stick_2 = self.slip_2 = self._u2
        self.slip_step = 0.0
        return False

    def _read_forces(self, dt_s: float) -> bool:
        """Read and check forces, update the ledger; return whether the pair opened or closed."""
        forces = ops.basicForce(self.element)
        u1, u2, kt, opening, ledger = self._u1, self._u2, self.kt, self.opening, self.ledger
        normal, force_1 = -forces[0], forces[1]
        force_2 = forces[2] if self._is_3d else 0.0
        expected_n = -self.kn * opening if opening < 0.0 else 0.0
        if abs(normal - expected_n) > FORCE_ROUNDING * self.kn * (abs(opening) + abs(self.gap_m)):
            raise ContactError(
                f"contact {self.name!r} (element {self.element}): the normal spring gives "
                f"{normal:.9g} N, expected {expected_n:.9g} N; were its parameters changed?"
            )
        self._check_friction(force_1, force_2)
        if self.springs.dashpot is not None:
            normal -= forces[-1]
        slip_1, slip_2 = u1 - force_1 / kt, u2 - force_2 / kt
        moved_1, moved_2 = slip_1 - self.slip_1, slip_2 - self.slip_2
        ledger.slip_work_j += 0.5 * (
            (force_1 + self.force_1) * moved_1 + (force_2 + self.force_2) * moved_2
        )
        ledger.normal_work_j += 0.5 * (normal + self.normal_n) * (self.opening_before - opening)
        friction_n = hypot(force_1, force_2)
        slip_m = hypot(moved_1, moved_2)
        self.slip_step = slip_m
        closed, was_closed = opening < 0.0, self.closed
        limit = friction_limit_n(normal, self.friction, self.cohesion) if closed else 0.0
        self.excess_ratio = 0.0
        if friction_n > 0.0:
            self._record_excess(friction_n, limit, slip_m, dt_s)
            sliding_1_n, sliding_2_n = SLIDING_SHARE * self._bound_1, SLIDING_SHARE * self._bound_2
            if abs(force_1) >= sliding_1_n > 0.0 or abs(force_2) >= sliding_2_n > 0.0:
                self.excess_ratio = abs(self.excess_ratio)  # a bound below the limit is wrong too
        if closed:
            ledger.contact_time_s += dt_s
            ledger.slip_path_m += slip_m
            if -opening > ledger.max_penetration_m:
                ledger.max_penetration_m = -opening
            if friction_n > ledger.max_friction_n:
                ledger.max_friction_n = friction_n
            if limit > ledger.max_limit_n:
                ledger.max_limit_n = limit
            if not was_closed:
                ledger.closures += 1
                before = self.opening_before
                # Contact starts where the pair closed, not where the step began.
                share = opening / (opening - before) if before > 0.0 else 1.0
                self._stick_1, self._stick_2 = u1 - share * self._step_1, u2 - share * self._step_2
        self._slip_1_before, self._slip_2_before = self.slip_1, self.slip_2
        self.slip_1, self.slip_2, self.force_1, self.force_2 = slip_1, slip_2, force_1, force_2
        self.normal_n, self.closed = normal, closed
        # A pair that has just opened still holds the friction of the step: read it once more.
        self._has_forces = closed or friction_n > 0.0 or normal != 0.0
        self._move_stick_point(limit)
        return closed != was_closed

    def _record_excess(self, force_n: float, limit_n: float, moved_m: float, dt_s: float) -> None:
        ledger, work_j, excess_n = self.ledger, force_n * moved_m, force_n - limit_n
        ledger.friction_impulse_ns += force_n * dt_s
        ledger.friction_work_j += work_j
        if moved_m > 0.0 and force_n > LEAST_FRICTION * ledger.max_friction_n:
            self.excess_ratio = excess_n / force_n
        if excess_n <= 0.0:
            return
        ledger.max_violation_n = max(ledger.max_violation_n, excess_n)
        ledger.excess_work_j += excess_n * moved_m
        if excess_n > 0.1 * limit_n:
            ledger.work_over_10_j += work_j

    def _check_friction(self, force_1: float, force_2: float) -> None:
        if abs(force_1) <= self._bound_1 and abs(force_2) <= self._bound_2:
            return
        tolerance_n = FORCE_ROUNDING * self.kt * (abs(self._u1) + abs(self._u2))
        if abs(force_1) > self._bound_1 + tolerance_n or abs(force_2) > self._bound_2 + tolerance_n:
            raise ContactError(
                f"contact {self.name!r} (element {self.element}): the friction springs give "
                f"({force_1:.6g}, {force_2:.6g}) N outside their bounds "
                f"({self._bound_1:.6g}, {self._bound_2:.6g}) N; were the parameters removed?"
            )

    def _move_stick_point(self, limit_n: float) -> None:
        """Update the vector stick point for the committed position and normal force."""
        u1, u2 = self._u1, self._u2
        if not self.closed:
            self._stick_1, self._stick_2 = u1, u2
            return
        offset_1, offset_2 = u1 - self._stick_1, u2 - self._stick_2
        stick_radius = limit_n / self.kt
        distance = hypot(offset_1, offset_2)
        if distance > stick_radius:
            scale = stick_radius / distance
            self._stick_1, self._stick_2 = u1 - scale * offset_1, u2 - scale * offset_2

    def set_bounds(self, ratio: float | None) -> None:
        """Set the friction bounds for a next step that is `ratio` times as long as the last step.

        If `ratio` is None, the bounds follow from the last committed state.
        """
        if ratio is None:
            limit, offset_1, offset_2 = self._committed()
        else:
            limit, offset_1, offset_2 = self._predict(ratio)
        bounds = limit, 0.0
        if self._is_3d and limit > 0.0:
            trial_1, trial_2 = abs(self.kt * offset_1), abs(self.kt * offset_2)
            held_1, held_2 = max(trial_1, abs(self.force_1)), max(trial_2, abs(self.force_2))
            is_falling = ratio is not None and (trial_1 < held_1 or trial_2 < held_2)
            if is_falling and hypot(held_1, held_2) < limit and self._is_static():
                trial_1, trial_2 = held_1, held_2
            bounds = yields_on_cone(trial_1, trial_2, limit)
        self._update(*bounds)

    def _is_static(self) -> bool:
        """Return whether the pair moved while its nodes kept the velocities that they had at rest.

        A static step does not continue the motion before it. Under a constant load, the pair has to
        hold its force: with bounds for a smaller predicted force it would slide.
        """
        has_moved = self._step_1 or self._step_2 or self._bend_1 or self._bend_2
        return bool(has_moved) and self._read_velocities() == self._velocities

    def _committed(self) -> tuple[float, float, float]:
        """Return friction limit (N) and offsets (m) from the stick point in the committed state."""
        normal_n = self.normal_n if self.closed else 0.0
        limit = friction_limit_n(normal_n, self.friction, self.cohesion)
        return limit, self._u1 - self._stick_1, self._u2 - self._stick_2

    def _predict(self, ratio: float) -> tuple[float, float, float]:
        """Return friction limit (N) and offsets (m) from the stick point after the coming step."""
        opening = self.opening
        predicted = opening + ratio * (opening - self.opening_before)
        if predicted >= 0.0:
            return 0.0, 0.0, 0.0
        normal = -self.kn * predicted
        if self.dashpot:
            normal -= self.dashpot * (opening - self.opening_before) / self._dt
        limit = friction_limit_n(normal, self.friction, self.cohesion)
        # While the pair is open the stick point follows the node: only the part after closing
        # counts.
        offset_1, offset_2 = self._u1 - self._stick_1, self._u2 - self._stick_2
        if opening > 0.0:
            closed_share = ratio * predicted / (predicted - opening)
            offset_1, offset_2 = closed_share * self._step_1, closed_share * self._step_2
            # The springs followed the node to the start of the step, before the pair closes. With
            # a bound of at most the friction at the end of the step they follow until it closes.
            return min(limit, self.kt * hypot(offset_1, offset_2)), offset_1, offset_2
        # The direction of slip turns fastest where the speed is small: there the curvature of the
        # path counts. Only the direction depends on it, so plane models do not need it.
        curvature = 0.5 * ratio * (ratio + 1.0)
        return (
            limit,
            offset_1 + ratio * self._step_1 + curvature * self._bend_1,
            offset_2 + ratio * self._step_2 + curvature * self._bend_2,
        )

    def _update(self, bound_1: float, bound_2: float) -> None:
        if bound_1 != self._bound_1:
            ops.updateParameter(self.springs.bounds[0], bound_1)
            self._bound_1 = bound_1
        if bound_2 != self._bound_2:
            ops.updateParameter(self.springs.bounds[1], bound_2)
            self._bound_2 = bound_2
        if bound_1 or bound_2:
            self._has_forces = True


class ComponentwiseUnit(ContactUnit):
    """Literal reading of the paper: the two springs yield independently.

    The bounds are the limit times the direction cosines of the displacement from the plastic
    strains of the springs. In space, the result does not converge with the time step.
    """

    __slots__ = ()

    def _move_stick_point(self, limit_n: float) -> None:
        if self.closed:
            self._stick_1, self._stick_2 = self._slip_1_before, self._slip_2_before
        else:
            self._stick_1, self._stick_2 = self._u1, self._u2

    def set_bounds(self, ratio: float | None) -> None:
        """Set the bounds of the coming step; see `ContactUnit.set_bounds`."""
        if ratio is None:
            # The stick point is from before the last step, so the offsets are from before its
            # return. Offsets from after it would freeze the direction of the bounds.
            limit, offset_1, offset_2 = self._committed()
        else:
            if self.closed:
                self._stick_1, self._stick_2 = self.slip_1, self.slip_2
            limit, offset_1, offset_2 = self._predict(ratio)
        if limit <= 0.0:
            self._update(0.0, 0.0)
        elif self._is_3d:
            self._update(*yields_by_direction(offset_1, offset_2, limit))
        else:
            self._update(limit, 0.0)


class ElasticUnit(ContactUnit):
    """Elastic springs with a stick point moved by parameter updates (paper, section 2.1).

    The bound parameters hold the offset of the springs (minus the stick point); the springs are
    switched off by their modulus while the pair is open.
    """

    __slots__ = ("_modulus",)

    def start(self) -> None:
        """Switch the springs off until the pair closes."""
        self._modulus = self.kt
        self._switch(0.0)

    def scale_tangents(self, ratio: float) -> None:
        """Set the stiffness of the springs to `ratio` times their current stiffness."""
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, ratio * self._modulus)

    def _switch(self, modulus: float) -> None:
        if modulus != self._modulus:
            for parameter in self.springs.moduli:
                ops.updateParameter(parameter, modulus)
            self._modulus = modulus

    def _check_friction(self, force_1: float, force_2: float) -> None:
        expected_1 = self._modulus * (self._u1 + self._bound_1)
        expected_2 = self._modulus * (self._u2 + self._bound_2)
        tolerance_n = FORCE_ROUNDING * self.kt * (abs(self._u1) + abs(self._u2))
        if hypot(force_1 - expected_1, force_2 - expected_2) > tolerance_n:
            raise ContactError(
                f"contact {self.name!r} (element {self.element}): the elastic friction springs "
                "do not follow their stick point; were the parameters removed?"
            )

    def set_bounds(self, ratio: float | None) -> None:
        """Set the stick point of the coming step; see `ContactUnit.set_bounds`."""
        stick_1, stick_2 = self._stick_1, self._stick_2
        if ratio is None:
            limit = self._committed()[0]
        else:
            limit, offset_1, offset_2 = self._predict(ratio)
            force_1, force_2 = radial_return(offset_1, offset_2, self.kt, limit)
            if self.opening > 0.0:
                # If the pair closes in the step, the offset includes only the part after closing.
                position_1 = self._u1 + ratio * self._step_1
                position_2 = self._u2 + ratio * self._step_2
            else:
                position_1, position_2 = stick_1 + offset_1, stick_2 + offset_2
            stick_1, stick_2 = position_1 - force_1 / self.kt, position_2 - force_2 / self.kt
        if limit <= 0.0:
            self._switch(0.0)
            return
        self._has_forces = True
        self._switch(self.kt)
        self._update(-stick_1, -stick_2 if self._is_3d else 0.0)

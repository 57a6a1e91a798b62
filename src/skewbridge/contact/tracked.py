"""What a contact unit keeps between steps, and everything that is not its inner loop."""

from copy import copy
from math import inf
from typing import Any

import openseespy.opensees as ops

from skewbridge.contact.element import Springs
from skewbridge.contact.frame import Vector
from skewbridge.contact.law import ContactLaw
from skewbridge.contact.ledger import Account
from skewbridge.contact.state import Drive, UnitState


class TrackedUnit:
    """A node-to-node pair whose friction springs get their bounds from the tracked state.

    Made by `ContactSet.add`; what a caller may use are the attributes below.

    Attributes:
        name: Name given by the caller.
        node_i: Node of the surface.
        node_j: Node of the body.
        element: Tag of the zeroLength element.
        normal: Outward normal of the surface.
        tangents: One direction of the contact plane in plane models, two in space.
        gap_m: Initial gap (less what a drive has closed).
    """

    __slots__ = (
        "_b1", "_b2", "_bend_1", "_bend_2", "_dt", "_e1", "_e2", "_gap_closing", "_is_space",
        "_is_watched", "_opening_before", "_slip_1_before", "_slip_2_before", "_step_1", "_step_2",
        "_stick_1", "_stick_2", "account", "approach_speed", "closed", "cohesion", "dashpot",
        "drive", "element", "force_1", "force_2", "friction", "gap_m", "kn", "kt", "moved", "name",
        "node_i", "node_j", "normal", "normal_n", "opening", "over", "slip_1", "slip_2", "springs",
        "tangents",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        nodes: tuple[int, int],
        frame: tuple[Vector, ...],
        law: ContactLaw,
        springs: Springs,
        drive: Drive | None = None,
    ) -> None:
        self.name, self.springs, self.element = name, springs, springs.element
        self.node_i, self.node_j = nodes
        self.normal, self.tangents = frame[0], frame[1:]
        self.gap_m = law.open_gap_m
        self.kn, self.kt = law.kn_n_per_m, law.kt_n_per_m
        self.friction, self.cohesion, self.dashpot = law.friction, law.cohesion_n, 0.0
        self.drive = drive
        self.account = Account()
        self._is_space = len(frame) == 3
        self.closed = self._is_watched = False
        self.opening = self._opening_before = law.open_gap_m
        self.normal_n = self.force_1 = self.force_2 = 0.0
        self._e1 = self._e2 = self._step_1 = self._step_2 = self._bend_1 = self._bend_2 = 0.0
        self._stick_1 = self._stick_2 = self.slip_1 = self.slip_2 = 0.0
        self._slip_1_before = self._slip_2_before = 0.0
        self._b1 = self._b2 = self._gap_closing = 0.0
        self.moved = self.approach_speed = self._dt = self.over = 0.0
        self.start()

    def start(self) -> None:
        """Bring the springs into the state of an open pair; they are created without strength."""

    def steps_to_change(self) -> float:
        """Return in how many steps like the last one the pair opens or closes, or inf."""
        towards = self._opening_before - self.opening
        return self.opening / towards if self.opening * towards > 0.0 else inf

    def normal_potential_j(self) -> float:
        """Return the energy stored in the normal spring."""
        return 0.5 * self.kn * self.opening**2 if self.opening < 0.0 else 0.0

    def state(self, dt_s: float) -> UnitState:
        """Return the state at the end of the last committed step, before one of `dt_s`."""
        change = self.opening - self._opening_before
        return UnitState(
            is_closed=self.closed,
            opening_m=self.opening,
            opening_rate_mps=change / self._dt if self._dt else 0.0,
            normal_n=self.normal_n,
            tangential_n=(self.force_1, self.force_2),
            slip_m=(self.slip_1, self.slip_2),
            position_m=(self._e1, self._e2),
            slip_speed_mps=self.moved / self._dt if self._dt else 0.0,
            slip_path_m=self.account.slip_path_m,
            slip_work_j=self.account.slip_work_j,
            approach_speed_mps=self.approach_speed,
            dt_s=dt_s,
        )

    def rest(self) -> None:
        """Read the springs as they are and forget the motion that led there."""
        deformation, forces = ops.basicDeformation(self.element), ops.basicForce(self.element)
        self.opening = self._opening_before = self.gap_m + deformation[0]
        self._e1 = deformation[1]
        self.normal_n, self.force_1 = -forces[0], forces[1]
        if self._is_space:
            self._e2 = deformation[2]
            self.force_2 = forces[2]
        self._step_1 = self._step_2 = self._bend_1 = self._bend_2 = 0.0
        self.closed = self._is_watched = self.opening < 0.0
        self.slip_1 = self._stick_1 = self._e1 - self.force_1 / self.kt
        self.slip_2 = self._stick_2 = self._e2 - self.force_2 / self.kt

    def apply_drive(self, dt_s: float, time_s: float) -> None:
        """Let the user function set parameters for the coming step."""
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
        if "gap_closing_m" in values and self.springs.gap_offset is not None:
            change = values["gap_closing_m"] - self._gap_closing
            self._gap_closing += change
            self.gap_m -= change
            self.opening -= change
            self._opening_before -= change
            ops.updateParameter(self.springs.gap_offset, -self._gap_closing)

    def scale_tangents(self, ratio: float) -> None:
        """Set the stiffness of the friction springs to `ratio` times their own."""
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, ratio * self.kt)

    def snapshot(self) -> dict[str, Any]:
        """Return everything that is tracked."""
        names = [slot for base in type(self).__mro__ for slot in getattr(base, "__slots__", ())]
        saved = {slot: getattr(self, slot) for slot in names}
        return saved | {"account": copy(self.account)}

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to a snapshot and set its bounds again."""
        for slot, value in saved.items():
            setattr(self, slot, value)
        self.account = copy(self.account)
        for parameter, bound in zip(self.springs.bounds, (self._b1, self._b2), strict=False):
            ops.updateParameter(parameter, bound)

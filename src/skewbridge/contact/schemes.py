"""Two alternative friction schemes, for comparison with the vector stick point of `unit`."""

from math import hypot
from typing import Any

import openseespy.opensees as ops

from skewbridge.contact.element import ContactError
from skewbridge.contact.law import radial_return, yields_by_direction
from skewbridge.contact.unit import FORCE_ROUNDING, ContactUnit


class ComponentwiseUnit(ContactUnit):
    """The literal reading of the paper: each spring returns to its own yield.

    The bounds are the limit times the direction cosines of the displacement from the springs' own
    plastic strains. In space this does not converge with the time step (the force lags the
    velocity by 25.4 degrees instead of 13.0 on a circle of radius 0.2 m).
    """

    __slots__ = ()

    def _move_stick_point(self, limit_n: float) -> None:
        if self.closed:
            self._stick_1, self._stick_2 = self._slip_1_before, self._slip_2_before
        else:
            self._stick_1, self._stick_2 = self._e1, self._e2

    def set_bounds(self, ratio: float | None) -> None:
        """Set the bounds of the coming step; see `ContactUnit.set_bounds`."""
        if ratio is None:
            # The stick point is that before the last step, so the offsets are those before the
            # return. With the offsets after it, the direction of the bounds would freeze.
            limit, offset_1, offset_2 = self._committed()
        else:
            if self.closed:
                self._stick_1, self._stick_2 = self.slip_1, self.slip_2
            limit, offset_1, offset_2 = self._predict(ratio)
        if limit <= 0.0:
            self._update(0.0, 0.0)
        elif self._is_space:
            self._update(*yields_by_direction(offset_1, offset_2, limit))
        else:
            self._update(limit, 0.0)


class ElasticUnit(ContactUnit):
    """Elastic springs whose stick point is moved by us (section 2.1 of the paper).

    The bound parameters hold the offset of the springs (minus the stick point); the springs are
    switched off by their modulus while the pair is open.
    """

    __slots__ = ("_modulus",)

    def start(self) -> None:
        """Switch the springs off until the pair closes."""
        self._modulus = self.kt
        self._switch(0.0)

    def scale_tangents(self, ratio: float) -> None:
        """Set the stiffness of the springs to `ratio` times the current one."""
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, ratio * self._modulus)

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to a snapshot and set its stick point again."""
        super().restore(saved)
        for parameter in self.springs.moduli:
            ops.updateParameter(parameter, self._modulus)

    def _switch(self, modulus: float) -> None:
        if modulus != self._modulus:
            for parameter in self.springs.moduli:
                ops.updateParameter(parameter, modulus)
            self._modulus = modulus

    def _check_friction(self, force_1: float, force_2: float) -> None:
        expected_1 = self._modulus * (self._e1 + self._b1)
        expected_2 = self._modulus * (self._e2 + self._b2)
        slack = FORCE_ROUNDING * self.kt * (abs(self._e1) + abs(self._e2))
        if hypot(force_1 - expected_1, force_2 - expected_2) > slack:
            raise ContactError(
                f"contact {self.name!r}: the elastic friction springs left their stick point"
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
                # In a step in which the pair closes, the offset holds only the part after closing.
                position_1 = self._e1 + ratio * self._step_1
                position_2 = self._e2 + ratio * self._step_2
            else:
                position_1, position_2 = stick_1 + offset_1, stick_2 + offset_2
            stick_1, stick_2 = position_1 - force_1 / self.kt, position_2 - force_2 / self.kt
        if limit <= 0.0:
            self._switch(0.0)
            return
        self._is_watched = True
        self._switch(self.kt)
        self._update(-stick_1, -stick_2 if self._is_space else 0.0)

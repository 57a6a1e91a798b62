"""Plan geometry of a skewed deck end.

Positive skew turns the abutment lines counter-clockwise from the transverse axis. The origin is
at the middle of the deck; heights are measured from the soffit.
"""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Literal

type PlanVector = tuple[float, float]
type Side = Literal["left", "right"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckEnd:
    """One end of the deck in plan, ``left`` (negative x) or ``right``.

    The bearing line crosses the centreline at ``bearing_x_m``, the skew is signed, the width is
    that across the deck, the thickness that of the end diaphragm, normal to its faces.
    """

    side: Side
    bearing_x_m: float
    skew_rad: float
    width_m: float
    thickness_m: float

    @property
    def sign(self) -> float:
        """+1 at the right end."""
        return 1.0 if self.side == "right" else -1.0

    @property
    def normal(self) -> PlanVector:
        """Outward normal of the end face."""
        return (self.sign * cos(self.skew_rad), self.sign * sin(self.skew_rad))

    @property
    def inward(self) -> PlanVector:
        """Normal of the backwall, towards the deck."""
        return (-self.normal[0], -self.normal[1])

    @property
    def tangent(self) -> PlanVector:
        """The normal turned by +90 degrees: along the wall."""
        return (-self.normal[1], self.normal[0])

    @property
    def wall_length_m(self) -> float:
        """Length of the end face along the wall."""
        return self.width_m / cos(self.skew_rad)

    @property
    def acute_sign(self) -> float:
        """Side of the acute deck corner along the tangent; at zero skew as at a positive one."""
        return 1.0 if self.skew_rad < 0.0 else -1.0

    def point(self, line: Literal["inner", "bearing", "outer"], along_m: float) -> PlanVector:
        """Return a point of a transverse array, ``along_m`` from the centreline along the wall."""
        # ASSUME the arrays stand at the faces and in the middle of the end diaphragm
        faces = {"inner": -0.5, "bearing": 0.0, "outer": 0.5}[line]
        offset = faces * self.thickness_m * self.sign / cos(self.skew_rad)
        return (
            self.bearing_x_m + offset + along_m * self.tangent[0],
            along_m * self.tangent[1],
        )

    def wall_stations(self, count: int) -> list[float]:
        """Return positions along the wall, corners included, increasing."""
        half = self.wall_length_m / 2
        return [half * (2 * i / (count - 1) - 1) for i in range(count)]


def deck_end(
    side: Side, length_m: float, skew_deg: float, width_m: float, thickness_m: float
) -> DeckEnd:
    """Return the end of a deck whose bearing lines are ``length_m`` apart."""
    sign = 1.0 if side == "right" else -1.0
    return DeckEnd(
        side=side,
        bearing_x_m=sign * length_m / 2,
        skew_rad=radians(skew_deg),
        width_m=width_m,
        thickness_m=thickness_m,
    )


def tributary_shares(count: int) -> list[float]:
    """Return the share of the wall behind each of equally spaced points, corners included.

    From three points on, springs in these shares resist a turn of the deck as a continuous wall
    does; half a spacing at each corner would be stiffer by 12 % with five points.
    """
    inner = 1.0 / (count - 1)
    shares = [inner / 2 if i in (0, count - 1) else inner for i in range(count)]
    if count > 2:
        # moved inwards from each corner, so that the sum of share times place squared is 1 / 12
        moved = inner / (12 * (1 - inner))
        for corner, beside in ((0, 1), (-1, -2)):
            shares[corner] -= moved
            shares[beside] += moved
    return shares

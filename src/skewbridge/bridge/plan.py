"""Geometry of deck ends in plan: pure functions and data.

Axes: x longitudinal, y transverse, z up. Positive skew turns the line of an abutment
counter-clockwise from the normal of the deck's centreline.
"""

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Literal

type PlanVector = tuple[float, float]
type Position = tuple[float, float, float]
#: Line of the pads, or outer face of the end diaphragm, where walls and keys touch it.
type Line = Literal["bearing", "outer"]


def turned(direction: PlanVector) -> PlanVector:
    """Return a plan direction turned by +90 degrees."""
    return (-direction[1], direction[0])


@dataclass(frozen=True, slots=True)
class DeckEnd:
    """One end of a deck in plan, with signed skew."""

    name: str  # name in tables and histories, for example ``left``
    middle_m: PlanVector  # crossing of the bearing line and the centreline of the deck
    outward: PlanVector  # unit vector of the centreline, out of the deck
    skew_deg: float  # angle from ``outward`` to the normal of the end face, counter-clockwise
    width_m: float  # width of the deck, square to the centreline
    thickness_m: float  # thickness of the end diaphragm, normal to its faces
    soffit_m: float = 0.0  # height z of the soffit, where all points of the joint are

    @property
    def skew_rad(self) -> float:
        """Signed skew in rad."""
        return radians(self.skew_deg)

    @property
    def normal(self) -> PlanVector:
        """Outward normal of the end face."""
        (x, y), c, s = self.outward, cos(self.skew_rad), sin(self.skew_rad)
        return (x * c - y * s, x * s + y * c)

    @property
    def inward(self) -> PlanVector:
        """Normal of the backwall, towards the deck."""
        return (-self.normal[0], -self.normal[1])

    @property
    def tangent(self) -> PlanVector:
        """The normal turned by +90 degrees: along the wall."""
        return turned(self.normal)

    @property
    def wall_length_m(self) -> float:
        """Length of the end face along the wall."""
        return self.width_m / cos(self.skew_rad)

    @property
    def acute_sign(self) -> float:
        """+1 if the acute corner is at the end of the tangent, else -1; zero skew is positive."""
        return 1.0 if self.skew_rad < 0.0 else -1.0

    def point(self, line: Line, along_m: float) -> Position:
        """Return the point of a line, ``along_m`` from the centreline along the wall."""
        # ASSUME the pads are under the middle of the end diaphragm
        thickness_ratio, (x, y) = {"bearing": 0.0, "outer": 0.5}[line], self.tangent
        offset_m = thickness_ratio * self.thickness_m / cos(self.skew_rad)
        middle, outward = self.middle_m, self.outward
        return (
            middle[0] + offset_m * outward[0] + along_m * x,
            middle[1] + offset_m * outward[1] + along_m * y,
            self.soffit_m,
        )

    def wall_stations(self, count: int) -> list[float]:
        """Return increasing, equally spaced positions (m) along the wall, including corners."""
        half = self.wall_length_m / 2
        return [half * (2 * i / (count - 1) - 1) for i in range(count)]


def tributary_shares(count: int) -> list[float]:
    """Return the share of the wall for each of three or more equally spaced points with corners.

    The springs have the rotational stiffness of a continuous wall; with shares of half a spacing at
    the corners, five springs would be 12 % too stiff.
    """
    interior = 1.0 / (count - 1)
    shares = [interior / 2 if i in (0, count - 1) else interior for i in range(count)]
    # moved inwards from each corner so that the sum of share x position^2 is 1 / 12
    shift = interior / (12 * (1 - interior))
    for corner, neighbour in ((0, 1), (-1, -2)):
        shares[corner] -= shift
        shares[neighbour] += shift
    return shares

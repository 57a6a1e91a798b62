"""Coulomb friction with cohesion and a vector stick point, and unilateral contact: pure functions.

Signs: `opening_m` is positive while the pair is apart, `normal_n` is positive in compression, and
the tangential force has the sign of the slip (it is the force of the spring; the moving body feels
its negative). All values are plain floats, because these functions run in the inner loop of the
response histories. Two values are those along the two directions of the contact plane (the second
is zero in plane models). `ContactUnit` takes the yields from here and repeats the other formulas
for speed.

References:
    Rahman and Mackie (2023), Finite Elements in Analysis and Design 218 (parameter updates);
    Simo and Hughes (1998), Computational Inelasticity, chapter 2 (return mapping).
"""

from dataclasses import dataclass
from math import hypot, isfinite, sqrt

from skewbridge.errors import InputError


# ASSUME Coulomb friction, static equal to kinetic, the same in all directions of the contact plane.
# ASSUME the contact itself is elastic: restitution comes from a driven damper only.
@dataclass(frozen=True, slots=True, kw_only=True)
class ContactLaw:
    """A contact pair: penalties, Coulomb friction with cohesion, initial gap.

    Attributes:
        kn_n_per_m: Normal penalty stiffness.
        kt_n_per_m: Tangential penalty stiffness.
        friction: Coulomb coefficient.
        cohesion_n: Part of the friction limit that does not depend on the normal force; it acts
            only while the pair is closed.
        gap_m: Initial opening.
        gap_closing_m: Part of the gap already closed by temperature, creep or shrinkage.

    Raises:
        InputError: A value is outside its limits.
    """

    kn_n_per_m: float
    kt_n_per_m: float
    friction: float = 0.0
    cohesion_n: float = 0.0
    gap_m: float = 0.0
    gap_closing_m: float = 0.0

    def __post_init__(self) -> None:
        for name in ("kn_n_per_m", "kt_n_per_m"):
            if not (isfinite(value := getattr(self, name)) and value > 0.0):
                raise InputError(f"{name} must be a positive finite stiffness, got {value}")
        for name in ("friction", "cohesion_n", "gap_m", "gap_closing_m"):
            if not (isfinite(value := getattr(self, name)) and value >= 0.0):
                raise InputError(f"{name} must be finite and not negative, got {value}")
        if self.gap_closing_m > self.gap_m:
            raise InputError(
                f"gap_closing_m must be at most gap_m = {self.gap_m}, got {self.gap_closing_m}"
            )

    @property
    def open_gap_m(self) -> float:
        """Gap left to close."""
        return self.gap_m - self.gap_closing_m


@dataclass(frozen=True, slots=True, kw_only=True)
class PairState:
    """State of a pair at the end of a step, forces with the sign of slip."""

    is_closed: bool
    is_slipping: bool
    normal_n: float
    force_1_n: float
    force_2_n: float
    stick_1_m: float
    stick_2_m: float


def normal_force_n(opening_m: float, kn_n_per_m: float) -> float:
    """Return the compression of a pair: a penalty while the opening is negative, never tension."""
    return -kn_n_per_m * opening_m if opening_m < 0.0 else 0.0


def friction_limit_n(normal_n: float, friction: float, cohesion_n: float) -> float:
    """Return the radius of the cone; zero while open, so that cohesion acts only in contact."""
    return cohesion_n + friction * normal_n if normal_n > 0.0 else 0.0


def radial_return(
    offset_1_m: float, offset_2_m: float, kt_n_per_m: float, limit_n: float
) -> tuple[float, float]:
    """Return the tangential force for an offset from the stick point, returned to the cone.

    Offsets are position minus stick point, the limit is the radius of the cone. After slip the
    stick point is the position minus force / kt.
    """
    trial_1, trial_2 = kt_n_per_m * offset_1_m, kt_n_per_m * offset_2_m
    size = hypot(trial_1, trial_2)
    if size <= limit_n:
        return trial_1, trial_2
    scale = limit_n / size
    return scale * trial_1, scale * trial_2


def advance_pair(
    law: ContactLaw,
    stick_m: tuple[float, float],
    position_m: tuple[float, float],
    opening_m: float,
) -> PairState:
    """Advance a pair by one step with the normal force at its end (the exact discrete law).

    The stick point is that at the end of the last step, position and opening (the gap is part of
    it) are those at the end of this one.
    """
    position_1, position_2 = position_m
    normal = normal_force_n(opening_m, law.kn_n_per_m)
    if normal <= 0.0:
        return PairState(
            is_closed=False,
            is_slipping=False,
            normal_n=0.0,
            force_1_n=0.0,
            force_2_n=0.0,
            stick_1_m=position_1,
            stick_2_m=position_2,
        )
    limit = friction_limit_n(normal, law.friction, law.cohesion_n)
    kt = law.kt_n_per_m
    offset_1, offset_2 = position_1 - stick_m[0], position_2 - stick_m[1]
    force_1, force_2 = radial_return(offset_1, offset_2, kt, limit)
    is_slipping = kt * hypot(offset_1, offset_2) > limit
    return PairState(
        is_closed=True,
        is_slipping=is_slipping,
        normal_n=normal,
        force_1_n=force_1,
        force_2_n=force_2,
        stick_1_m=position_1 - force_1 / kt if is_slipping else stick_m[0],
        stick_2_m=position_2 - force_2 / kt if is_slipping else stick_m[1],
    )


def yields_on_cone(trial_1_n: float, trial_2_n: float, limit_n: float) -> tuple[float, float]:
    """Return the yield forces of two separate springs that together stay inside the cone.

    The pair of yields lies on the cone. For a trial force outside the cone it is the point of
    radial return. For one inside, both yields exceed the trial by the same slack, so that a
    component near zero does not make a sticking pair slip.
    """
    size_1, size_2 = abs(trial_1_n), abs(trial_2_n)
    size = hypot(size_1, size_2)
    if size >= limit_n:
        scale = limit_n / size if size > 0.0 else 0.0
        return scale * size_1, scale * size_2
    half = 0.5 * (size_1 + size_2)
    slack = sqrt(half * half + 0.5 * (limit_n * limit_n - size * size)) - half
    # Rounding makes a slack near zero negative; a yield below the trial would be a slip.
    slack = max(slack, 0.0)
    return size_1 + slack, size_2 + slack


def yields_by_direction(trial_1_n: float, trial_2_n: float, limit_n: float) -> tuple[float, float]:
    """Return the yields as the direction cosines of the trial times the limit (the paper)."""
    size = hypot(trial_1_n, trial_2_n)
    if size == 0.0:
        share = limit_n * sqrt(0.5)
        return share, share
    return limit_n * abs(trial_1_n) / size, limit_n * abs(trial_2_n) / size

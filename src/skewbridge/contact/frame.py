"""Local frames of contact pairs: the normal and one or two directions of the contact plane."""

from collections.abc import Sequence
from math import isfinite, sqrt
from typing import Final

from skewbridge.errors import InputError

type Vector = tuple[float, ...]

# ASSUME a pair keeps the directions it is created with, and its contact plane has no edges.

# Directions that are meant to be perpendicular may be off by rounding of four-digit input.
ORTHOGONALITY_LIMIT: Final = 1e-4
_VERTICAL_LIMIT: Final = 1e-6


def unit_vector(vector: Sequence[float], field: str, ndm: int) -> Vector:
    """Return a vector of length one.

    Raises:
        InputError: The vector has a wrong number of components, is zero or not finite.
    """
    values = tuple(float(value) for value in vector)
    if len(values) != ndm:
        raise InputError(
            f"{field} must have {ndm} components in a model of {ndm} dimensions, got {values}"
        )
    length = sqrt(sum(value * value for value in values))
    if not (isfinite(length) and length > 0.0):
        raise InputError(f"{field} must be a finite vector of positive length, got {values}")
    return tuple(value / length for value in values)


def contact_frame(
    normal: Sequence[float], tangent: Sequence[float] | None, ndm: int
) -> tuple[Vector, ...]:
    """Return the orthonormal frame (normal, tangent) in the plane, (normal, t1, t2) in space.

    Args:
        normal: Outward normal of the surface, any length.
        tangent: First direction of the contact plane; by default horizontal (z x normal), and x
            for a vertical normal; in the plane always the normal turned counter-clockwise.
        ndm: Dimensions of the model, 2 or 3.

    Raises:
        InputError: A vector is zero, or the tangent is not perpendicular to the normal.
    """
    if ndm not in (2, 3):
        raise InputError(f"contacts need a model of 2 or 3 dimensions, got ndm = {ndm}")
    n = unit_vector(normal, "normal", ndm)
    if tangent is None:
        t1 = _default_tangent(n)
    else:
        t1 = unit_vector(tangent, "tangent", ndm)
        cosine = sum(a * b for a, b in zip(n, t1, strict=True))
        if abs(cosine) > ORTHOGONALITY_LIMIT:
            raise InputError(
                "normal and tangent must be perpendicular (cosine at most "
                f"{ORTHOGONALITY_LIMIT}), got a cosine of {cosine:.3g}"
            )
        t1 = unit_vector([b - cosine * a for a, b in zip(n, t1, strict=True)], "tangent", ndm)
    if ndm == 3:
        return n, t1, cross(n, t1)
    # OpenSees takes the normal turned by 90 degrees in plane models, whatever it is given.
    if n[0] * t1[1] - n[1] * t1[0] < 0.0:
        raise InputError(
            f"tangent must be the normal turned counter-clockwise in plane models, got {t1}"
        )
    return n, t1


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of two vectors in space."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _default_tangent(n: Vector) -> Vector:
    if len(n) == 2:
        return (-n[1], n[0])
    horizontal = (n[0] * n[0] + n[1] * n[1]) ** 0.5
    if horizontal < _VERTICAL_LIMIT:
        return unit_vector([1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2]], "tangent", 3)
    return (-n[1] / horizontal, n[0] / horizontal, 0.0)

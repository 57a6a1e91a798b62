"""OpenSees objects of one contact: tags, local frame, zeroLength element and its parameters.

A parameter is attached by position (`'material', k, 'Fy'`). The short form without `'material'`
reaches every material of the element, including the normal spring, and silently removes the
contact; OpenSees also accepts a wrong name silently. Hence every parameter is read back from the
element and its effect on a force is checked before use.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isfinite, sqrt
from typing import ClassVar, Final, Protocol

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact.law import ContactLaw
from skewbridge.errors import InputError

type Direction = tuple[float, ...]

# ASSUME a pair keeps the directions it is created with, and its contact plane has no edges.

# Largest cosine between perpendicular directions: rounding of four-digit input.
ORTHOGONALITY_LIMIT: Final = 1e-4
_VERTICAL_LIMIT: Final = 1e-6


def unit_vector(vector: Sequence[float], field: str, ndm: int) -> Direction:
    """Return a unit vector; `InputError` if the size is wrong or the length zero or infinite."""
    values = tuple(float(value) for value in vector)
    if len(values) != ndm:
        raise InputError(
            f"{field} must have {ndm} components in a model of {ndm} dimensions, got {values}"
        )
    norm = sqrt(sum(value * value for value in values))
    if not (isfinite(norm) and norm > 0.0):
        raise InputError(f"{field} must be a finite vector of positive length, got {values}")
    return tuple(value / norm for value in values)


def contact_frame(
    normal: Sequence[float], tangent: Sequence[float] | None, ndm: int
) -> tuple[Direction, ...]:
    """Return the orthonormal frame (normal, tangent) in the plane, (normal, t1, t2) in space.

    The default tangent is horizontal (z x normal), or x for a vertical normal; in the plane (`ndm`
    is 2) it is always the normal turned counter-clockwise. Raises `InputError` if a vector is zero,
    or the tangent is not perpendicular to the normal.
    """
    if ndm not in (2, 3):
        raise InputError(f"contacts need a model of 2 or 3 dimensions, got ndm = {ndm}")
    n = unit_vector(normal, "normal", ndm)
    if tangent is None:
        is_vertical = ndm == 3 and hypot(n[0], n[1]) < _VERTICAL_LIMIT
        tangent = (1.0, 0.0, 0.0) if is_vertical else (-n[1], n[0], 0.0)[:ndm]
    t1 = unit_vector(tangent, "tangent", ndm)
    cosine = sum(a * b for a, b in zip(n, t1, strict=True))
    if abs(cosine) > ORTHOGONALITY_LIMIT:
        raise InputError(
            "normal and tangent must be perpendicular (cosine at most "
            f"{ORTHOGONALITY_LIMIT}), got a cosine of {cosine:.3g}"
        )
    t1 = unit_vector([b - cosine * a for a, b in zip(n, t1, strict=True)], "tangent", ndm)
    if ndm == 3:
        return n, t1, tuple(np.cross(n, t1).tolist())
    # In plane models, OpenSees always uses the normal turned by 90 degrees.
    if n[0] * t1[1] - n[1] * t1[0] < 0.0:
        raise InputError(
            f"tangent must be the normal turned counter-clockwise in plane models, got {t1}"
        )
    return n, t1


# ASSUME material tags of the user are below this one: OpenSees cannot list them.
FIRST_FREE_MATERIAL: Final = 900_000


class Tags(Protocol):
    """Source of unused tags, for example the allocator of a bridge model."""

    def element(self) -> int:
        """Return an unused tag of an element."""
        ...

    def material(self) -> int:
        """Return an unused tag of a material."""
        ...

    def parameter(self) -> int:
        """Return an unused tag of a parameter."""
        ...


class TagSource:
    """Source of tags above all tags in the domain; material tags start from a given number.

    No source repeats a material tag of another: materials outlive the elements that used them.
    """

    _next_material: ClassVar[int] = 0  # of the process, like the domain

    def __init__(self, first_material: int = FIRST_FREE_MATERIAL) -> None:
        self._first = first_material

    def element(self) -> int:
        """Return an unused element tag."""
        return _free(ops.getEleTags())

    def material(self) -> int:
        """Return an unused uniaxial material tag."""
        tag = max(self._first, TagSource._next_material)
        TagSource._next_material = tag + 1
        return tag

    def parameter(self) -> int:
        """Return an unused parameter tag."""
        return _free(ops.getParamTags())


def _free(tags: list[int] | int | None) -> int:
    """Return the largest tag plus 1; OpenSees returns a number instead of a list of one tag."""
    return (tags if isinstance(tags, int) else max(tags or (), default=0)) + 1


def uniaxial(tags: Tags, kind: str, *values: float | str) -> int:
    """Create a uniaxial material and return its tag."""
    material = tags.material()
    ops.uniaxialMaterial(kind, material, *values)
    return material


# Yield penetration of the normal spring, never reached.
_NEVER_M: Final = 1.0e3
# Yield of the friction springs when created; odd on purpose, so that reading it back through a
# parameter proves which material the parameter is attached to.
_SIGNATURE_M: Final = 0.0617
_PROBE_M: Final = 1.0e-3
_RELATIVE_ROUNDING: Final = 1e-9
_DOF_COUNTS: Final = {2: (2, 3), 3: (3, 6)}  # by dimensions of the model


class ContactError(RuntimeError):
    """A contact element does not follow its parameters: its results must not be used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Springs:
    """Tags of the zeroLength element of one contact and of its parameters.

    Bounds are yield forces of the friction springs, or their initial strains in scheme elastic.
    """

    element: int
    normal_modulus: int
    moduli: tuple[int, ...]
    bounds: tuple[int, ...]
    dashpot: int | None = None


def require_nodes(nodes: tuple[int, int], ndm: int) -> None:
    """Raise `InputError` for nodes that are not in the domain or cannot form a pair."""
    existing = set(ops.getNodeTags())
    for field, node in zip(("node_i", "node_j"), nodes, strict=True):
        if node not in existing:
            raise InputError(f"{field} must be a node of the domain, got {node}")
    if nodes[0] == nodes[1]:
        raise InputError(f"node_i and node_j must differ, got {nodes[0]} twice")
    counts = tuple(len(ops.nodeDisp(node)) for node in nodes)
    if counts[0] != counts[1] or counts[0] not in _DOF_COUNTS[ndm]:
        raise InputError(
            f"both nodes must have the same number of degrees of freedom, "
            f"{' or '.join(map(str, _DOF_COUNTS[ndm]))} in {ndm} dimensions; "
            f"nodes {nodes} have {counts}"
        )


def make_springs(
    tags: Tags,
    nodes: tuple[int, int],
    frame: tuple[Direction, ...],
    law: ContactLaw,
    driven: Sequence[str],
    *,
    is_elastic: bool,
) -> Springs:
    """Create the element and its parameters; raise `ContactError` if a parameter has no effect.

    ``driven`` names the parameters set by a drive; a dashpot is created only if it is one of them.
    """
    tangent_count, has_dashpot = len(frame) - 1, "dashpot_n_s_per_m" in driven
    kn, kt = law.kn_n_per_m, law.kt_n_per_m
    # acts in compression once the gap is closed: gap and yield have the same sign
    gap_arguments = (kn, -kn * _NEVER_M, -law.gap_m, 0.0, "noDamage")
    normal = uniaxial(tags, "ElasticPPGap", *gap_arguments)
    if is_elastic:
        spring = uniaxial(tags, "Elastic", kt)
        tangential = uniaxial(tags, "InitStrainMaterial", spring, _SIGNATURE_M)
    else:
        tangential = uniaxial(tags, "ElasticPP", kt, _SIGNATURE_M)
    materials, dofs = [normal] + [tangential] * tangent_count, list(range(1, tangent_count + 2))
    if has_dashpot:
        materials.append(uniaxial(tags, "Elastic", 0.0))
        dofs.append(1)
    element = tags.element()
    axes = ("-orient", *_orientation(frame))
    springs = ("-mat", *materials, "-dir", *dofs, "-doRayleigh", 0)
    ops.element("zeroLength", element, *nodes, *springs, *axes)
    bound_name = "epsInit" if is_elastic else "Fy"
    created = Springs(
        element=element,
        normal_modulus=_attach(tags, element, 1, "E"),
        moduli=tuple(_attach(tags, element, k, "E") for k in range(2, tangent_count + 2)),
        bounds=tuple(_attach(tags, element, k, bound_name) for k in range(2, tangent_count + 2)),
        dashpot=_attach(tags, element, tangent_count + 2, "eta") if has_dashpot else None,
    )
    _prove(created, law, is_elastic=is_elastic)
    return created


def prove_bounds_act(tags: Tags, nodes: tuple[int, int], frame: tuple[Direction, ...]) -> None:
    """Check with a probe element that a bound limits its own spring and no other.

    A bound takes effect at the next state determination, which a live domain makes only in an
    analysis. A probe element between the same nodes gets an initial strain above its yield
    strains. Its forces are read, then it is removed. A wrong force raises `ContactError`.
    """
    stiffness, bound_n, yield_n = 1.0e9, 2.0, 7.0
    yield_m = yield_n / stiffness
    normal, friction = (
        uniaxial(tags, "InitStrainMaterial", spring, 0.0)
        for spring in (
            uniaxial(tags, "ElasticPPGap", stiffness, yield_n, yield_m, 0.0, "noDamage"),
            uniaxial(tags, "ElasticPP", stiffness, yield_m),
        )
    )
    element = tags.element()
    dofs = range(1, len(frame) + 1)
    materials, axes = (normal, *[friction] * (len(frame) - 1)), _orientation(frame)
    ops.element("zeroLength", element, *nodes, "-mat", *materials, "-dir", *dofs, "-orient", *axes)
    # The value of the bound is also a large strain, so one parameter sets both: OpenSees does not
    # release 3 kB of each parameter that is removed.
    parameter = _attach(tags, element, 2, "Fy")
    for position in dofs:
        ops.addToParameter(parameter, "element", element, "material", position, "epsInit")
    ops.updateParameter(parameter, bound_n)
    forces = ops.basicForce(element)
    ops.remove("parameter", parameter)
    ops.remove("element", element)
    _expect("yield force of the normal spring", forces[0], yield_n)
    _expect("bounded friction force", forces[1], bound_n)
    if len(frame) == 3:
        _expect("yield force of the second friction spring", forces[2], yield_n)


def _attach(tags: Tags, element: int, position: int, name: str) -> int:
    parameter = tags.parameter()
    ops.parameter(parameter, "element", element, "material", position, name)
    return parameter


def _orientation(frame: tuple[Direction, ...]) -> list[float]:
    """Return local x and a vector in the local xy plane, three components each."""
    return [value for axis in frame[:2] for value in (*axis, 0.0)[:3]]


def _prove(springs: Springs, law: ContactLaw, *, is_elastic: bool) -> None:
    """Read every parameter back from the element and check that the element responds to it."""
    kt = law.kt_n_per_m
    initial_bound = _SIGNATURE_M if is_elastic else kt * _SIGNATURE_M
    _expect("normal stiffness", ops.getParamValue(springs.normal_modulus), law.kn_n_per_m)
    component_count = len(springs.bounds) + (1 if springs.dashpot is None else 2)
    for position, (modulus, bound) in enumerate(
        zip(springs.moduli, springs.bounds, strict=True), start=1
    ):
        _expect("tangential stiffness", ops.getParamValue(modulus), kt)
        _expect("friction bound", ops.getParamValue(bound), initial_bound)
        if is_elastic:
            ops.updateParameter(bound, _PROBE_M)
            _expect("friction force", ops.basicForce(springs.element)[position], kt * _PROBE_M)
        ops.updateParameter(modulus, 2.0 * kt)
        stiffness = ops.basicStiffness(springs.element)[position * (component_count + 1)]
        _expect("stiffness of the element", stiffness, 2.0 * kt)
        ops.updateParameter(modulus, kt)
        ops.updateParameter(bound, 0.0)
        _expect("friction bound", ops.getParamValue(bound), 0.0)


def _expect(quantity: str, value: float, expected: float) -> None:
    if abs(value - expected) > _RELATIVE_ROUNDING * abs(expected):
        raise ContactError(
            f"a contact parameter does not act: {quantity} is {value:.9g} but {expected:.9g} "
            "was set. This OpenSees build handles parameters differently from version 3.8."
        )

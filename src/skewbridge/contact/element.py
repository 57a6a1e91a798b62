"""The OpenSees side of one contact: a zeroLength element, its materials and its parameters.

A parameter is attached by position (`'material', k, 'Fy'`). The short form without `'material'`
reaches every material of the element, the normal spring included, and silently removes the
contact; a wrong name is accepted silently, too. Hence nothing here is trusted before it has been
read back from the element and seen to act.
"""

from dataclasses import dataclass
from typing import Final

import openseespy.opensees as ops

from skewbridge.contact.frame import Vector
from skewbridge.contact.law import ContactLaw
from skewbridge.contact.tags import Tags
from skewbridge.errors import InputError

# The normal spring would yield at this penetration: never.
_NEVER_M: Final = 1.0e3
# Yield of the friction springs when created; odd on purpose, so that reading it back through a
# parameter proves which material the parameter is attached to.
_SIGNATURE_M: Final = 0.0617
_PROBE_M: Final = 1.0e-3
_RELATIVE_ROUNDING: Final = 1e-9
_DOF_COUNTS: Final = {2: (2, 3), 3: (3, 6)}  # by dimensions of the model


class ContactError(RuntimeError):
    """A contact element does not do what it was told: its results must not be used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Springs:
    """Tags of one contact element: the zeroLength element, and its parameters.

    Those of the normal stiffness, the tangential stiffnesses, the friction bounds (yields, or
    stick points in scheme elastic), and if driven of the dashpot and of the normal spring's offset.
    """

    element: int
    normal_modulus: int
    moduli: tuple[int, ...]
    bounds: tuple[int, ...]
    dashpot: int | None = None
    gap_offset: int | None = None


def require_nodes(nodes: tuple[int, int], ndm: int) -> None:
    """Refuse nodes that no contact can stand between.

    Raises:
        InputError: A node is not in the domain, or the two do not suit each other.
    """
    existing = set(ops.getNodeTags())
    for field, node in zip(("node_i", "node_j"), nodes, strict=True):
        if node not in existing:
            raise InputError(f"{field} must be a node of the domain, got {node}")
    if nodes[0] == nodes[1]:
        raise InputError(f"node_i and node_j must differ, got {nodes[0]} twice")
    counts = tuple(len(ops.nodeDisp(node)) for node in nodes)
    if counts[0] != counts[1] or counts[0] not in _DOF_COUNTS[ndm]:
        raise InputError(
            f"both nodes must have {' or '.join(map(str, _DOF_COUNTS[ndm]))} degrees of freedom "
            f"in {ndm} dimensions, nodes {nodes} have {counts}"
        )


def make_springs(
    tags: Tags,
    nodes: tuple[int, int],
    frame: tuple[Vector, ...],
    law: ContactLaw,
    *,
    is_elastic: bool = False,
    has_dashpot: bool = False,
    is_gap_driven: bool = False,
) -> Springs:
    """Create the element and its parameters, and prove that each parameter acts.

    Raises:
        ContactError: A parameter is not attached to the material it was meant for.
    """
    directions = len(frame) - 1
    normal = _normal_material(tags, law, is_gap_driven=is_gap_driven)
    tangential = _tangential_material(tags, law.kt_n_per_m, is_elastic=is_elastic)
    materials, local = [normal] + [tangential] * directions, list(range(1, directions + 2))
    if has_dashpot:
        materials.append(tags.material())
        ops.uniaxialMaterial("Elastic", materials[-1], 0.0)
        local.append(1)
    element = tags.element()
    axes = ("-orient", *_orientation(frame))
    springs = ("-mat", *materials, "-dir", *local, "-doRayleigh", 0)
    ops.element("zeroLength", element, *nodes, *springs, *axes)
    bound_name = "epsInit" if is_elastic else "Fy"
    made = Springs(
        element=element,
        normal_modulus=_attach(tags, element, 1, "E"),
        moduli=tuple(_attach(tags, element, k, "E") for k in range(2, directions + 2)),
        bounds=tuple(_attach(tags, element, k, bound_name) for k in range(2, directions + 2)),
        dashpot=_attach(tags, element, directions + 2, "eta") if has_dashpot else None,
        gap_offset=_attach(tags, element, 1, "epsInit") if is_gap_driven else None,
    )
    _prove(made, law, is_elastic=is_elastic)
    return made


def prove_bounds_act(tags: Tags, nodes: tuple[int, int], frame: tuple[Vector, ...]) -> None:
    """See by force that a bound set through a parameter limits its own spring and no other.

    A bound acts at the next state determination, which a live domain makes only in an analysis.
    So a probe element between the same nodes, its springs behind an initial strain, is driven past
    all its yields, read and removed; nothing else of the domain is touched.

    Raises:
        ContactError: The force does not follow the bound.
    """
    stiffness, bound, other = 1.0e3, 2.0, 7.0
    yielding = other / stiffness
    springs = tags.material(), tags.material()
    ops.uniaxialMaterial("ElasticPPGap", springs[0], stiffness, other, yielding, 0.0, "noDamage")
    ops.uniaxialMaterial("ElasticPP", springs[1], stiffness, yielding)
    normal, friction = tags.material(), tags.material()
    for strained, spring in zip((normal, friction), springs, strict=True):
        ops.uniaxialMaterial("InitStrainMaterial", strained, spring, 0.0)
    element = tags.element()
    local = range(1, len(frame) + 1)
    materials, axes = (normal, *[friction] * (len(frame) - 1)), _orientation(frame)
    ops.element("zeroLength", element, *nodes, "-mat", *materials, "-dir", *local, "-orient", *axes)
    # The number of the bound is a large strain, too, so that one parameter serves for both:
    # OpenSees keeps 3 kB of each that is removed.
    probed = _attach(tags, element, 2, "Fy")
    for position in local:
        ops.addToParameter(probed, "element", element, "material", position, "epsInit")
    ops.updateParameter(probed, bound)
    forces = ops.basicForce(element)
    ops.remove("parameter", probed)
    ops.remove("element", element)
    _expect("yield of the normal spring", forces[0], other)
    _expect("bounded friction force", forces[1], bound)
    if len(frame) == 3:
        _expect("friction force of the other direction", forces[2], other)


def _normal_material(tags: Tags, law: ContactLaw, *, is_gap_driven: bool) -> int:
    """Return a spring that acts in compression behind the gap: gap and yield of one sign."""
    material = tags.material()
    kn, gap = law.kn_n_per_m, law.open_gap_m
    ops.uniaxialMaterial("ElasticPPGap", material, kn, -kn * _NEVER_M, -gap, 0.0, "noDamage")
    if not is_gap_driven:
        return material
    # The gap itself is no use as a parameter: OpenSees accepts it and goes on with the old one.
    offset = tags.material()
    ops.uniaxialMaterial("InitStrainMaterial", offset, material, 0.0)
    return offset


def _tangential_material(tags: Tags, kt_n_per_m: float, *, is_elastic: bool) -> int:
    material = tags.material()
    if not is_elastic:
        ops.uniaxialMaterial("ElasticPP", material, kt_n_per_m, _SIGNATURE_M)
        return material
    ops.uniaxialMaterial("Elastic", material, kt_n_per_m)
    offset = tags.material()
    ops.uniaxialMaterial("InitStrainMaterial", offset, material, _SIGNATURE_M)
    return offset


def _attach(tags: Tags, element: int, position: int, name: str) -> int:
    parameter = tags.parameter()
    ops.parameter(parameter, "element", element, "material", position, name)
    return parameter


def _orientation(frame: tuple[Vector, ...]) -> tuple[float, ...]:
    """Return the local x and the vector in the local xy plane, three components each."""
    normal, tangent = frame[0], frame[1]
    if len(frame) == 3:
        return (*normal, *tangent)
    return (*normal, 0.0, *tangent, 0.0)


def _prove(springs: Springs, law: ContactLaw, *, is_elastic: bool) -> None:
    """Read every parameter back from the element and see its response follow."""
    kt = law.kt_n_per_m
    signature = _SIGNATURE_M if is_elastic else kt * _SIGNATURE_M
    _expect("normal stiffness", ops.getParamValue(springs.normal_modulus), law.kn_n_per_m)
    size = len(springs.bounds) + (1 if springs.dashpot is None else 2)
    for position, (modulus, bound) in enumerate(
        zip(springs.moduli, springs.bounds, strict=True), start=1
    ):
        _expect("tangential stiffness", ops.getParamValue(modulus), kt)
        _expect("friction bound", ops.getParamValue(bound), signature)
        if is_elastic:
            ops.updateParameter(bound, _PROBE_M)
            _expect("force", ops.basicForce(springs.element)[position], kt * _PROBE_M)
        ops.updateParameter(modulus, 2.0 * kt)
        stiffness = ops.basicStiffness(springs.element)[position * (size + 1)]
        _expect("stiffness", stiffness, 2.0 * kt)
        ops.updateParameter(modulus, kt)
        ops.updateParameter(bound, 0.0)
        _expect("friction bound", ops.getParamValue(bound), 0.0)


def _expect(quantity: str, value: float, expected: float) -> None:
    if abs(value - expected) > _RELATIVE_ROUNDING * abs(expected):
        raise ContactError(
            f"contact parameter does not act: {quantity} is {value:.9g} where {expected:.9g} "
            "was set. The OpenSees build attaches parameters differently from 3.8."
        )

"""OpenSees domain, assembly of a bridge in it (frame, dead load, joints, contacts), and modes."""

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from math import inf, isinf, pi, sqrt
from os import devnull
from pathlib import Path
from typing import Literal

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.frame import Blueprint, BridgeModel, Frame
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.joints import KINDS, require_no_uplift, support_joint, support_on_bent
from skewbridge.bridge.script_units import end_view
from skewbridge.bridge.structures import CatalogueBridge
from skewbridge.contact import ContactSet
from skewbridge.errors import SolutionError
from skewbridge.variant.axes import USUAL
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

#: Builds the frame of a bridge for a skew, options and tags; see `Structure`.
type FrameBuilder = Callable[[float, ModelOptions, TagAllocator], Frame]

_GRAVITY_STEPS = 5
# Girders of several spans twist in up to 30 modes that are longer than the first vertical one.
_MOST_MODES = 56
_LEAST_MASS = 0.05
_INFINITE = 1.0e15  # eigenvalue (1/s2) of a mode without mass
_TOLERANCE_M = 1.0e-10


class DomainError(RuntimeError):
    """The domain already contains a model."""


class GravityError(SolutionError):
    """The gravity analysis of a model did not converge."""


@contextmanager
def domain() -> Generator[None]:
    """Open the only OpenSees domain of the process: empty on entry, wiped on exit."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    try:
        yield
    finally:
        ops.wipe()
        end_view()


@contextmanager
def solver_log(path: Path | None) -> Generator[None]:
    """Write OpenSees messages to ``path`` inside the block (None: discard); discard later ones."""
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
    ops.logFile(devnull if path is None else str(path), "-noEcho")
    try:
        yield
    finally:
        ops.logFile(devnull, "-noEcho")


def assemble(build_frame: FrameBuilder, variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a frame and its joints in the open domain, at rest under the dead load.

    The dead load rotates the deck ends, and gaps are openings at rest: joints are built after it.
    Raises `GravityError` without equilibrium.
    """
    tags = TagAllocator()
    frame = build_frame(variant.skew_deg, options, tags)
    blueprint = blueprint_of(variant, options, tags, has_joints=bool(frame.joints))
    ends_at_rest = [KINDS[end.abutment.type](end, blueprint) for end in frame.ends]
    joints_at_rest = [support_joint(joint, blueprint) for joint in frame.joints]
    bearing_lines = tuple(support_on_bent(line, blueprint) for line in frame.bearing_lines)
    hold_dead_load(frame.loads.forces_n, frame.loads.moments_nm, tags)
    for line, pads in zip(frame.bearing_lines, bearing_lines, strict=True):
        require_no_uplift(line.plan.name, pads.bearings)
    joints = tuple(build() for build in joints_at_rest)
    abutments = tuple(build() for build in ends_at_rest)
    return BridgeModel(
        variant=blueprint.variant,
        options=options,
        tags=tags,
        contacts=blueprint.contacts,
        frame=frame,
        abutments=abutments,
        joints=joints,
        bearing_lines=bearing_lines,
    )


def require_empty_domain() -> None:
    """Raise `DomainError` if the open domain already has a model."""
    if ops.getNodeTags():
        raise DomainError("the OpenSees domain has a model: build once in each `with domain():`")


def blueprint_of(
    variant: Variant, options: ModelOptions, tags: TagAllocator, *, has_joints: bool = False
) -> Blueprint:
    """Return the blueprint of a variant; contacts of model `contact` are never updated."""
    variant, contacts = variant.normalised(), None
    if variant.traits.has_contacts or has_joints:
        is_updated = variant.traits.has_friction
        contacts = ContactSet(tags, update=is_updated, coupling=options.coupling)
    return Blueprint(variant=variant, options=options, tags=tags, contacts=contacts)


def hold_dead_load(
    loads_n: Mapping[int, float], moments_nm: Mapping[int, tuple[float, float]], tags: TagAllocator
) -> None:
    """Apply and hold downward loads and moments about x and y at nodes; set the time to zero.

    Loads are nodal: the corotational transformation ignores element loads. `GravityError` without
    equilibrium.
    """
    open_linear_pattern(tags)
    for node, load_n in loads_n.items():
        ops.load(node, 0.0, 0.0, -load_n, *moments_nm.get(node, (0.0, 0.0)), 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", _TOLERANCE_M, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / _GRAVITY_STEPS)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(_GRAVITY_STEPS) != 0:
        text = "no equilibrium under dead load (a mechanism, such as a deck on rollers only?)"
        raise GravityError(f"the gravity analysis did not converge: {text}")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern proportional to time; loads created afterwards belong to it."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)


# --- modes with open gaps


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """Period of one mode, and the shares of the free mass that it moves along x, y, z, about z."""

    period_s: float  # infinite for a mechanism
    mass_x: float
    mass_y: float
    mass_z: float
    mass_rz: float


def modes_of(model: BridgeModel, count: int = 14) -> tuple[Mode, ...]:
    """Return the modes of a model under dead load with open gaps; the model is left as it was.

    Friction springs are made soft, walls and keys are held: their local modes would fill the list.
    A model of few masses has fewer modes. If ``count`` modes hardly move the mass along one of the
    axes, more are returned.
    """
    ends = model.abutments
    held = {node for end in ends for node in end.key_nodes}
    held |= {spring.nodes[1] for end in ends for spring in end.wing_springs}
    held_dofs = [(node, dof) for node in held for dof in {1, 2}.difference(ops.getFixedDOFs(node))]
    soft_friction = nullcontext() if model.contacts is None else model.contacts.soft_tangents()
    for node, dof in held_dofs:
        ops.fix(node, *(int(dof == number) for number in range(1, 7)))
    try:
        with soft_friction:
            masses = sum(
                ops.nodeMass(node, dof) > 0.0
                for node in ops.getNodeTags()
                for dof in {1, 2, 3, 4, 5, 6}.difference(ops.getFixedDOFs(node))
            )
            if masses < 2 * count:  # too few for ARPACK
                return _lowest_modes(masses, "-fullGenLapack")
            modes = _lowest_modes(count)
            with suppress(ops.OpenSeesError):  # the model has no more modes
                while len(modes) < _MOST_MODES and any(
                    max(getattr(mode, f"mass_{direction}") for mode in modes) < _LEAST_MASS
                    for direction in "xyz"
                ):
                    ops.wipeAnalysis()  # otherwise `eigen` refuses another number
                    modes = _lowest_modes(2 * len(modes))
            return modes
    finally:
        for node, dof in held_dofs:
            ops.remove("sp", node, dof)


def _lowest_modes(count: int, *solver: str) -> tuple[Mode, ...]:
    eigenvalues = [float(value) for value in ops.eigen(*solver, count)]
    ratios = ops.modalProperties("-return")
    keys = {"mass_x": "MX", "mass_y": "MY", "mass_z": "MZ", "mass_rz": "RMZ"}
    return tuple(
        Mode(
            period_s=2 * pi / sqrt(eigenvalue) if eigenvalue > 0.0 else inf,
            **{name: ratios[f"partiMassRatios{key}"][i] / 100 for name, key in keys.items()},
        )
        for i, eigenvalue in enumerate(eigenvalues)
        if eigenvalue < _INFINITE
    )


def period_s(modes: Sequence[Mode], direction: str) -> float:
    """Return the period of the mode with the most mass along ``x``, ``y`` or about z (``rz``).

    Along ``z``, where each simple span has its own mode, it is the longest period of the modes with
    at least half of the largest mass.
    """
    masses = [getattr(mode, f"mass_{direction}") for mode in modes]
    limit = max(masses) * (0.5 if direction == "z" else 1.0)
    return max(mode.period_s for mode, mass in zip(modes, masses, strict=True) if mass >= limit)


def bridge_period_s(
    bridge: BridgeData, which: Literal["t1", "long", "short"], *, on_rollers: bool = True
) -> float:
    """Return the conditioning period, or the long or short period of Rayleigh damping, in s.

    T1 is from the model with pads, open gaps and zero skew. The periods of damping are from cracked
    columns and deck ends on rollers (for the short period held transversely); without columns, or
    with bearings at bents, they are from the model of T1: on rollers, a span swings about them. The
    same for ``on_rollers=False``, and if the bridge cannot stand on rollers. Raises `ValueError`
    for a mechanism, or if the domain has a model, which would be lost.
    """
    if ops.getNodeTags():
        raise ValueError("the OpenSees domain has a model, which would be lost: wipe it first")
    has_rollers = on_rollers and which != "t1" and bool(bridge.bents)
    has_rollers = has_rollers and not bridge.bents_with_bearings
    variant = Variant.at(bridge.name, "roller" if has_rollers else "contact_friction", USUAL)
    # the gap of a joint is open, so it does not matter; on rollers, there is no other
    joints = tuple(joint.model_copy(update={"gap_mm": USUAL["gap_mm"]}) for joint in bridge.joints)
    try:
        with solver_log(None), domain():
            build = CatalogueBridge(bridge.model_copy(update={"joints": joints})).build
            model = assemble(build, variant, ModelOptions(elastic_columns=has_rollers))
            if has_rollers and which == "short":
                for end in (end for end in model.frame.ends if end.abutment.type != "fixed"):
                    ops.fix(end.node, 0, 1, 0, 0, 0, 0)
            modes = modes_of(model)
    except GravityError as error:
        raise ValueError(error) from error
    finally:
        ops.model("basic", "-ndm", 3, "-ndf", 6)  # of a domain in which a bridge is loaded
    x_s, y_s, z_s = (period_s(modes, axis) for axis in "xyz")
    if isinf(x_s + y_s + z_s):
        if has_rollers:
            return bridge_period_s(bridge, which, on_rollers=False)
        raise ValueError("the bridge is a mechanism: it lacks stiffness along x, y or z")
    if which == "t1":
        return sqrt(x_s * y_s)
    return max(x_s, y_s) if which == "long" else min(y_s, z_s)

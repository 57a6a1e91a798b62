"""OpenSees domain, and the assembly of a bridge in it: frame, dead load, joints, contacts."""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager

import openseespy.opensees as ops

from skewbridge.bridge.ends import KINDS
from skewbridge.bridge.frame import Blueprint, BridgeModel, Frame
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.joints import build_inner_joint, support_joint
from skewbridge.bridge.script_units import end_view
from skewbridge.contact import ContactSet
from skewbridge.errors import SolutionError
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

#: Builds the frame of a bridge for a skew, options and tags; see `Structure`.
type FrameBuilder = Callable[[float, ModelOptions, TagAllocator], Frame]


_GRAVITY_STEPS = 5
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


def assemble(build_frame: FrameBuilder, variant: Variant, options: ModelOptions) -> BridgeModel:
    """Build a frame and its joints in the open domain, at rest under the dead load.

    The dead load rotates the deck ends, and gaps are openings at rest: joints are built after it.
    Raises `DomainError` in a domain with a model, `GravityError` without equilibrium.
    """
    require_empty_domain()
    tags = TagAllocator()
    frame = build_frame(variant.skew_deg, options, tags)
    blueprint = blueprint_of(variant, options, tags, has_joints=bool(frame.joints))
    kinds = [KINDS[end.abutment.type] for end in frame.ends]
    supported = [kind.support(end, blueprint) for kind, end in zip(kinds, frame.ends, strict=True)]
    on_pads = [support_joint(joint, blueprint) for joint in frame.joints]
    hold_dead_load(frame.loads.forces_n, frame.loads.moments_nm, tags)
    joints = tuple(map(build_inner_joint, on_pads))
    abutments = tuple(kind.build(end) for kind, end in zip(kinds, supported, strict=True))
    return BridgeModel(blueprint=blueprint, frame=frame, abutments=abutments, joints=joints)


def require_empty_domain() -> None:
    """Raise `DomainError` if the open domain already has a model."""
    if ops.getNodeTags():
        raise DomainError("call build() inside `with domain():`, once per domain")


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
        raise GravityError("the gravity analysis did not converge: no equilibrium under dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern that grows with time; loads created afterwards belong to it."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)

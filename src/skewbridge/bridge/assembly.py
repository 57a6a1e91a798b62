"""OpenSees domain, and the assembly of a bridge in it: frame, dead load, joints, contacts."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

import openseespy.opensees as ops

from skewbridge.bridge.ends import KINDS
from skewbridge.bridge.frame import Blueprint, BridgeModel, Frame
from skewbridge.bridge.gravity import hold_dead_load
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.joints import build_inner_joint, support_joint
from skewbridge.bridge.script_units import end_view
from skewbridge.contact import ContactSet
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

#: Builds the frame of a bridge for a skew, options and tags; see `Structure`.
type FrameBuilder = Callable[[float, ModelOptions, TagAllocator], Frame]


class DomainError(RuntimeError):
    """The domain already contains a model."""


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

"""Contact and friction by run-time parameter updates, for any live OpenSees domain.

Attach contacts to a model that has nodes, then call one method after each converged step::

    contacts = ContactSet(tags)                       # tags optional: any TagSource-like object
    unit = contacts.add(
        node_i, node_j,                               # i: surface (backwall), j: body (deck)
        normal=(1.0, 0.0, 0.0),                       # outward of the surface, from i towards j
        gap_m=0.051, friction=0.5, cohesion_n=0.0,
        kn=2e9, kt=2e8,                               # N/m
        tangent=None, name="backwall 1",
    )                                                 # -> index of the unit, 0, 1, ...
    while ...:
        if ops.analyze(1, dt_s) != 0:                 # nothing was committed
            contacts.prepare(dt_s / 4)                # bounds for the retry with a smaller step
            ...
            continue
        changed = contacts.after_step(dt_s)           # bool: some unit opened or closed

Signatures::

    ContactSet(tags=None, *, update=True, scheme="vector", coupling="extrapolated")
        update=False: the model `contact` (same elements, parameters never updated, no friction).
        scheme: vector | componentwise | elastic;  coupling: extrapolated | lagged.
    .add(node_i, node_j, normal, gap_m, friction, cohesion_n=0.0, *, kn, kt, tangent=None,
         gap_closing_m=0.0, drive=None, name="") -> int
    .after_step(dt_s, next_dt_s=None) -> bool         # commit the tracked state; next_dt_s=dt_s
    .prepare(next_dt_s) -> None                       # bounds again, from the last committed state
    .start_from_rest() -> None                        # once, between gravity and the transient
    .change_expected(dt_s) -> bool                    # predicted opening/closing within dt_s
    .changes -> tuple[int, ...]                       # units that opened or closed in the last step
    .snapshot() -> object; .restore(snapshot)         # tracked state, for a caller that can go back
    .soft_tangents(ratio=1e-9)                        # context manager around `eigen` (modal trap)
    .state(unit) -> UnitState                         # is_closed, opening_m, penetration_m,
                                                      # normal_n, tangential_n (t1, t2), slip_m
    .openings_m, .normals_n, .tangentials_n, .closed  # lists over units, plain floats
    .global_force_on_j(unit) -> tuple[float, ...]     # N, ndm components, on node j
    .ledger() -> list[UnitLedger]                     # closures, contact_time_s, max_penetration_m,
                                                      # max_normal_n, max_friction_n, slip_work_j,
                                                      # normal_work_j, cone_violation_n, _ratio
    .units -> tuple of units with .element, .node_i, .node_j, .normal, .tangents, .name

    make_step(contacts, dt_s, parts_on_change=4)      # instead of analyze and after_step:
                                                      # sub-steps where a change is expected

Signs: opening is positive, normal_n > 0 is compression, the tangential force has the sign of the
slip of node j relative to node i (the force of the spring; the body feels its negative).
"""

from skewbridge.contact.contact_set import ContactSet
from skewbridge.contact.element import ContactError
from skewbridge.contact.law import ContactLaw
from skewbridge.contact.ledger import UnitLedger
from skewbridge.contact.state import Coupling, Drive, Scheme, Snapshot, UnitState
from skewbridge.contact.stepping import make_step
from skewbridge.contact.tags import Tags, TagSource
from skewbridge.contact.unit import ContactUnit

__all__ = [
    "ContactError",
    "ContactLaw",
    "ContactSet",
    "ContactUnit",
    "Coupling",
    "Drive",
    "Scheme",
    "Snapshot",
    "TagSource",
    "Tags",
    "UnitLedger",
    "UnitState",
    "make_step",
]

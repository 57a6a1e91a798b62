"""Contact and friction by run-time parameter updates, for any live OpenSees domain.

Attach contacts to a model that has nodes, then call one method after each converged step::

    contacts = ContactSet(tags)                       # tags optional: any object like TagSource
    unit = contacts.add(                              # index of the unit, 0, 1, ...
        node_i, node_j,                               # i: surface (backwall), j: body (deck)
        normal=(1.0, 0.0, 0.0),                       # outward normal of the surface, from i to j
        gap_m=0.051, friction=0.5, kn=2e9, kt=2e8,    # N/m
    )
    while ...:
        if ops.analyze(1, dt_s) != 0:                 # nothing was committed
            contacts.prepare(dt_s / 4)                # bounds for the retry with a smaller step
            ...
            continue
        changed = contacts.after_step(dt_s)           # True if a unit opened or closed

`ContactSet(update=False)` is the model `contact`: the same elements, never updated, no friction.
`make_step(contacts, dt_s, parts_on_change=4)` replaces analyze and after_step, with sub-steps
where a unit is expected to open or close.

Signs: opening is positive, normal_n > 0 is compression, the tangential force has the sign of the
slip of node j relative to node i (it is the spring force; the force on the body is opposite).
"""

from skewbridge.contact.contact_set import ContactSet, make_step
from skewbridge.contact.element import ContactError, Tags, TagSource
from skewbridge.contact.law import ContactLaw, Coupling, Drive, Scheme, UnitLedger, UnitState
from skewbridge.contact.unit import ContactUnit

__all__ = [
    "ContactError", "ContactLaw", "ContactSet", "ContactUnit", "Coupling", "Drive", "Scheme",
    "TagSource", "Tags", "UnitLedger", "UnitState", "make_step",
]  # fmt: skip

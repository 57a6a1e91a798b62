"""A time step of a model with contacts, made in parts when a pair is about to open or close."""

import openseespy.opensees as ops

from skewbridge.contact.contact_set import ContactSet


def make_step(contacts: ContactSet, dt_s: float, *, parts_on_change: int = 1) -> bool:
    """Make one step of the transient analysis and take it over into the contacts.

    A closing or an opening inside a step costs one order of accuracy. Sub-steps when one is
    expected bring that back for little. Use them with one-step integrators only: Houbolt starts
    anew, by the trapezoidal rule, whenever the step changes.

    Returns:
        Whether OpenSees made the step. If not, the domain is at the last part that was committed
        and the contacts with it.
    """
    parts = parts_on_change if contacts.time_to_change_s() < dt_s else 1
    part_s = dt_s / parts
    if parts > 1:
        contacts.prepare(part_s)
    for part in range(parts):
        if ops.analyze(1, part_s) != 0:
            return False
        contacts.after_step(part_s, dt_s if part == parts - 1 else part_s)
    return True

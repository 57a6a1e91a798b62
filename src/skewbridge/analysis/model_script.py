"""A variant as a plain OpenSeesPy script that needs nothing of this package."""

from skewbridge.analysis.damping import apply_rayleigh
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.recording import recording
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


def model_script(variant: Variant, options: ModelOptions) -> str:
    """Return a script that builds a variant, applies gravity and sets the damping.

    At its end a table lists the contact pairs with what their run-time updates need.

    Raises:
        InputError: Bad bridge or variant.
        GravityError: The model does not carry its weight.
    """
    with recording() as record, domain():
        model = build(variant, options)
        apply_rayleigh(model)
        return record.script(variant.normalised().slug) + _contact_table(model)


def _contact_table(model: BridgeModel) -> str:
    """Return the contacts as a Python list; parameters are those of the friction bounds."""
    if model.contacts is None:
        return ""
    rows = [
        f"    dict(name={unit.name!r}, element={unit.element}, node_i={unit.node_i}, "
        f"node_j={unit.node_j}, bounds={unit.springs.bounds}, gap_m={unit.gap_m!r}, "
        f"kn={unit.kn!r}, kt={unit.kt!r}, friction={unit.friction!r}, "
        f"cohesion_n={unit.cohesion!r}),"
        for unit in model.contacts.units
    ]
    return "\n".join(["", "CONTACTS = [", *rows, "]", ""])

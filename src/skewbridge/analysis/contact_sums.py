"""What the contacts of a model did over a history: sums of their ledgers.

Closures and peaks of single contacts depend on the time step; times, impulses and works converge
(docs/theory/analysis.md).
"""

from collections.abc import Sequence

from skewbridge.bridge.handles import BridgeModel
from skewbridge.contact.state import UnitLedger
from skewbridge.units import KJ, KN


def contact_demands(model: BridgeModel) -> dict[str, float]:
    """Return the contact columns of the demands table; all zero for a model without contacts.

    Shares of friction work are of that on all contacts, or of those on backwalls or keys.
    """
    units = [] if model.contacts is None else model.contacts.ledger()
    walls = [units[index] for side in model.abutments for index in side.wall_units]
    keys = [units[index] for side in model.abutments for index in side.key_units]
    return {
        "contact_closures": _sum(units, "closures"),
        "contact_time_s": _sum(units, "contact_time_s"),
        "contact_max_penetration_m": max((unit.max_penetration_m for unit in units), default=0.0),
        "friction_impulse_kns": _sum(units, "friction_impulse_ns") / KN,
        "slip_work_kj": _sum(units, "slip_work_j") / KJ,
        "friction_after_opening_ratio": _share(units, "opening_work_j"),
        "cone_violation_ratio": max((unit.cone_violation_ratio for unit in units), default=0.0),
        "cone_excess_wall_ratio": _share(walls, "excess_work_j"),
        "cone_excess_key_ratio": _share(keys, "excess_work_j"),
        **{
            f"cone_work_over_{percent}pct_ratio": _share(units, f"work_over_{percent}_j")
            for percent in (1, 10, 50)
        },
        **{
            f"cone_time_over_{percent}pct_ratio": _share(
                units, f"time_over_{percent}_s", "contact_time_s"
            )
            for percent in (1, 10, 50)
        },
    }


def _sum(units: Sequence[UnitLedger], field: str) -> float:
    return float(sum(getattr(unit, field) for unit in units))


def _share(units: Sequence[UnitLedger], field: str, whole: str = "friction_work_j") -> float:
    """Return the share of a sum in another one, zero where there is nothing to share."""
    total = _sum(units, whole)
    return _sum(units, field) / total if total > 0.0 else 0.0

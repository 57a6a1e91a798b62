"""Why a limit state was not reached: what limits the demand, or that the motions were too weak."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.plateau import Plateau, fit_plateau
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.limit_states import LimitState

LEVELS_OFF: Final = "plateau"
WEAK_MOTIONS: Final = "weak_motions"
NO_DEMAND: Final = "no_demand"
#: What limits a demand that levels off, by the name of its column.
MECHANISMS: Final = {
    "column_shear": ("plastic_hinge", "the plastic hinge"),
    "column_base_shear": ("plastic_hinge", "the plastic hinge"),
    "shear_key_force": ("key_strength", "the strength of the shear keys"),
    "backwall_force": ("backwall_strength", "the strength of backwall and backfill"),
    "friction_force": ("friction_bound", "the friction bound"),
}
# A ratio of force to capacity levels off where the force does, though its capacity still falls.
_FORCE_BEHIND: Final = {"column_shear_dcr": "column_shear_kn"}


def force_columns(demands: pd.DataFrame, columns: Sequence[str]) -> list[str]:
    """Return the forces behind some demands that the table has beside them."""
    forces = (_FORCE_BEHIND[name] for name in columns if name in _FORCE_BEHIND)
    return [name for name in forces if name in demands.columns and name not in columns]


class VariantReach:
    """The plateaus of the demands of one variant, each looked for once."""

    def __init__(self, part: pd.DataFrame, im_column: str) -> None:
        self._part, self._im_column = part, im_column
        self._complete = is_complete(part)
        self._found: dict[str, Plateau | None] = {}

    def columns(self, state: LimitState, *, reached: bool) -> dict[str, Any]:
        """Return the columns of the curve table that say what limits the demand of a state.

        ``reached`` says whether a run is known to exceed the state.
        """
        plateau = self._plateau(state.demand)
        force = self._plateau(_FORCE_BEHIND.get(state.demand, state.demand))
        levels = plateau is not None and (plateau.found or (force is not None and force.found))
        row: dict[str, Any] = {
            "plateau": plateau.level if plateau and levels else np.nan,
            "plateau_im": plateau.knee if plateau and levels else np.nan,
            "plateau_gain": plateau.gain if plateau else np.nan,
            "mechanism": "",
            "reach": "",
        }
        if reached:
            return row
        mechanism, text = self._reason(state, plateau if levels else None)
        return row | {"mechanism": mechanism, "reach": text}

    def _reason(self, state: LimitState, plateau: Plateau | None) -> tuple[str, str]:
        """Return mechanism and sentence of a state that no run reached."""
        values = self._values(state.demand)
        largest = float(np.max(values)) if values.size else 0.0
        label = label_of(state.demand)
        if not largest > 0.0:
            return NO_DEMAND, f"{label} is zero in every run"
        share = f"largest {largest:.2g}, state at {state.threshold:.2g}"
        if plateau is not None and plateau.top < state.threshold:
            for start, (mechanism, name) in MECHANISMS.items():
                if state.demand.startswith(start):
                    return mechanism, (
                        f"{label} is limited by {name}: it saturates at {plateau.level:.2g} "
                        f"({share})"
                    )
            return LEVELS_OFF, f"{label} levels off at {plateau.level:.2g} ({share})"
        return WEAK_MOTIONS, f"{label}: no motion is strong enough ({share})"

    def _values(self, demand: str) -> FloatArray:
        if demand not in self._part.columns:
            return np.empty(0)
        return self._part[demand].to_numpy(dtype=np.float64)[self._complete]

    def _plateau(self, demand: str) -> Plateau | None:
        if demand not in self._found:
            values = self._values(demand)
            usable = np.isfinite(values) & (values > 0.0)
            im = self._part[self._im_column].to_numpy(dtype=np.float64)[self._complete]
            fit = None
            if values.size and np.all(usable):
                fit = fit_plateau(im, values)
            self._found[demand] = fit
        return self._found[demand]

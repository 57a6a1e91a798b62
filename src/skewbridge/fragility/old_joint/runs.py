"""The runs of one bridge and abutment model as the joint model takes them."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.fragility.old_joint.terms import AxisBox, axes_of_model, box_of
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL, is_beyond_model
from skewbridge.fragility.tables.key_columns import motion_codes
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Outcomes, outcomes_of


@dataclass(frozen=True, slots=True, kw_only=True)
class JointRuns:
    """Runs of the variants of one bridge and abutment model, arrays of shape (n,).

    Attributes:
        table: Their rows of the demands table.
        ln_im: ln intensity.
        motion: Number of the motion, 0 .. G - 1.
        variant: Number of the variant, 0 .. V - 1.
        variants: One row per variant: its name and its axes.
        box: The axes that differ.
    """

    table: pd.DataFrame
    ln_im: FloatArray
    motion: NDArray[np.intp]
    variant: NDArray[np.intp]
    variants: pd.DataFrame
    box: AxisBox

    @property
    def motions(self) -> int:
        """Number of motions."""
        return int(np.max(self.motion)) + 1

    def of_demand(self, column: str) -> "JointRuns":
        """Return the runs with one demand alone, which is little to send to another process."""
        names = [name for name in (column, "status", BEYOND_MODEL) if name in self.table.columns]
        return replace(self, table=self.table[names])

    def demand(self, column: str) -> FloatArray:
        """Return a demand of every run."""
        return self.table[column].to_numpy(dtype=np.float64)

    def outcomes(self, state: LimitState) -> Outcomes:
        """Return what every run says about a limit state."""
        status = self.table["status"].to_numpy(dtype=str)
        return outcomes_of(self.demand(state.demand), status, is_beyond_model(self.table), state)


def joint_runs(part: pd.DataFrame, im_column: str) -> JointRuns:
    """Return the runs of one bridge and abutment model; ``part`` are their rows."""
    names = axes_of_model(part, str(part["abutment"].iloc[0]))
    codes, _ = pd.factorize(part["variant"], sort=True)
    first = np.unique(codes, return_index=True)[1]
    variants = part.iloc[first][["variant", *names]].reset_index(drop=True)
    return JointRuns(
        table=part,
        ln_im=np.log(part[im_column].to_numpy(dtype=np.float64)),
        motion=motion_codes(part),
        variant=codes.astype(np.intp),
        variants=variants,
        box=box_of(variants, names),
    )

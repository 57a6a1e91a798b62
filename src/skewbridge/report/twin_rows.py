"""Rows of the demands table that must be equal: no friction is contact, mirror images mirror."""

from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.variant.axes import axes_of

#: Same equations, numbering and springs: only the updates, which do nothing, are left out.
CONTACT_TOLERANCE: Final = 1e-9
#: Rounding differs between an analysis and its image and grows with every contact.
#: source: tests/verification/test_analysis_invariances.py, peaks of a whole motion
MIRROR_TOLERANCE: Final = 0.01
#: Below these a demand (in its own unit) is as good as nothing.
_CONTACT_NOTHING: Final = 1e-12
_MIRROR_NOTHING: Final = 1e-9
_RUN: Final = ("motion_id", "scale", "incidence_deg")
_TWIN: Final = "_of_twin"


def contact_twins(frictionless: pd.DataFrame, ok: pd.DataFrame) -> pd.DataFrame:
    """Return rows of ``contact_friction`` without friction that differ from those of ``contact``.

    Args:
        frictionless: Rows without friction and cohesion, of whatever abutment model.
        ok: Finished rows of the study.
    """
    with_law = frictionless[frictionless["abutment"] == "contact_friction"]
    without = ok[ok["abutment"] == "contact"]
    places = [axis.name for axis in axes_of(ok.columns) if axis.name != "friction"]
    names = [column.name for column in DEMAND_COLUMNS if column.name in ok]
    joined = with_law.merge(without, on=["bridge", *places, *_RUN], suffixes=("", _TWIN))
    return _different(joined, names, CONTACT_TOLERANCE, _CONTACT_NOTHING)


def mirror_twins(ok: pd.DataFrame, suite: pd.DataFrame) -> pd.DataFrame:
    """Return rows of positive skew that differ from their mirror image, where the study has it.

    The image has the opposite skew under the mirrored motion, which is one whose first component
    is the same and whose second is the negative, from the opposite angle.

    Args:
        ok: Finished rows of the study.
        suite: Motions with their accelerations.
    """
    if not (ok["skew_deg"] < 0).any():
        return ok.head(0)
    images = mirrored_motions(suite)
    left = ok[(ok["skew_deg"] > 0) & ok["motion_id"].isin(images)]
    wanted = left.assign(
        skew_deg=-left["skew_deg"],
        motion_id=left["motion_id"].map(images),
        incidence_deg=-left["incidence_deg"],
    )
    keys = ["bridge", "abutment", *(axis.name for axis in axes_of(ok.columns)), *_RUN]
    names = list(demands_for("effect", ok.columns))
    joined = wanted.merge(ok, on=keys, suffixes=("", _TWIN))
    found = _different(joined, names, MIRROR_TOLERANCE, _MIRROR_NOTHING)
    back = {image: name for name, image in images.items()}
    return found.assign(
        motion_id=found["motion_id"].map(back), incidence_deg=-found["incidence_deg"]
    )


def mirrored_motions(suite: pd.DataFrame) -> dict[str, str]:
    """Return the name of the mirror image of every motion that has one in the suite."""
    # 0.0 is added so that a negative zero is the same number as a zero
    named = {
        (_bytes(row.accel_1_mps2), _bytes(row.accel_2_mps2)): str(row.motion_id)
        for row in suite.itertuples()
    }
    found: dict[str, str] = {}
    for row in suite.itertuples():
        image = (_bytes(row.accel_1_mps2), _bytes(-np.asarray(row.accel_2_mps2)))
        if image in named:
            found[str(row.motion_id)] = named[image]
    return found


def _bytes(values: object) -> bytes:
    return (np.asarray(values, dtype=float) + 0.0).tobytes()


def _different(
    joined: pd.DataFrame, names: list[str], tolerance: float, nothing: float
) -> pd.DataFrame:
    """Return the rows in which a number is not that of the twin."""
    one = joined[names].to_numpy(float)
    other = joined[[f"{name}{_TWIN}" for name in names]].to_numpy(float)
    close = np.isclose(one, other, rtol=tolerance, atol=nothing, equal_nan=True)
    return joined[~close.all(axis=1)]

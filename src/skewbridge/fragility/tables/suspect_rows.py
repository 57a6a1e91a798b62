"""Suspect rows in the fits: like all others, or as outcomes that are not known."""

import numpy as np
import pandas as pd

from skewbridge.analysis.suspect import SUSPECT
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.statuses import Status

UNKNOWN: Status = "numerical_failure"


def rows_to_fit(demands: pd.DataFrame, settings: FitSettings) -> pd.DataFrame:
    """Return the demands table as the fits take it.

    If suspect rows are excluded, each stays as a failed analysis without demands: the fits count it
    as unknown and say what it may change, the paired effects leave it out.
    """
    if not settings.exclude_suspect or SUSPECT not in demands:
        return demands
    names = [column.name for column in DEMAND_COLUMNS if column.name in demands]
    table, suspect = demands.copy(), demands[SUSPECT] != ""
    table.loc[suspect, names] = np.nan
    table.loc[suspect, "status"] = UNKNOWN
    table.loc[suspect, BEYOND_MODEL] = ""
    return table

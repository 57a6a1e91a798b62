"""Every table of results/fragility, made of one table of demands: what rules and commands call."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.fragility.old_joint.table import joint_table
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.im_quality import measure_table
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.needed_motions import needed_motions
from skewbridge.fragility.tables.ordered_curves import ordered_curves
from skewbridge.fragility.tables.paper_table import latex_table, paper_table
from skewbridge.fragility.tables.suspect_rows import rows_to_fit
from skewbridge.fragility.tables.system_curves import system_curves
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import provenance, write_frame

PAPER_TABLE: Final = "table"


def fit_tables(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings,
    suite: pd.DataFrame | None = None,
    *,
    jobs: int = 1,
) -> dict[str, pd.DataFrame]:
    """Return what is fitted to limit states, by file name: curves, medians, systems, joint models.

    With the table of the suite, which has magnitudes and distances, intensity measures are ranked.
    ``jobs`` is the number of processes.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    rows = rows_to_fit(demands, settings)
    fits = (fit_study, ordered_curves)
    curves = pd.concat(
        [fit(rows, limit_states, settings.im, settings, jobs=jobs) for fit in fits],
        ignore_index=True,
    )
    medians = paired_capacity_effects(rows, limit_states, settings.im, settings, jobs=jobs)
    joint = joint_table(rows, limit_states, settings.im, curves, settings, jobs=jobs)
    ranked = {} if suite is None else {"measures": measure_table(rows, suite, settings)}
    return ranked | {
        "curves": curves,
        "median_effects": medians,
        "system": system_curves(rows, limit_states, settings.im, settings, jobs=jobs),
        "joint": joint,
        PAPER_TABLE: paper_table(curves, medians, joint, settings),
    }


def effect_tables(
    demands: pd.DataFrame,
    settings: FitSettings,
    further: Sequence[str] = (),
    *,
    jobs: int = 1,
) -> dict[str, pd.DataFrame]:
    """Return the effects of the axes on the demands, by file name.

    ``further`` are demand columns beside those with the role ``effect`` that the table has;
    ``jobs`` is the number of processes.

    Raises:
        InputError: A column is missing, or a run occurs twice.
    """
    rows = rows_to_fit(demands, settings)
    names = list(dict.fromkeys((*demands_for("effect", rows.columns), *further)))
    effects = paired_effects(rows, names, settings, jobs=jobs)
    return {
        "effects": effects,
        "needed_motions": needed_motions(effects, rows),
        "factors": factor_summary(rows, names, settings, jobs=jobs),
    }


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as parquet files; that of a paper as CSV and LaTeX, for readers and editors."""
    for name, table in tables.items():
        if name == PAPER_TABLE:
            write_text(folder / f"{name}.csv", table.to_csv(index=False, float_format="%.6g"))
            write_text(folder / f"{name}.tex", latex_table(table))
        else:
            write_frame(table, folder / f"{name}.parquet", provenance())

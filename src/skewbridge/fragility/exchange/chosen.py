"""The curves of one method of a study, as other tools take them."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_table
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.tables.key_columns import need_columns

#: Dispersion of a curve as it is drawn and exported: that of the capacity included.
CURVE_BETA = "curve_beta"
_NEEDED = (
    "variant", "component", "limit_state", "method", "status", "im", "theta", "beta", "beta_total",
    "threshold",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenCurves:
    """Curves of one method.

    Attributes:
        method: Of the fits.
        rows: All of them, those without an estimate too; ``curve_beta`` is beta_total, or beta
            where no slope carries the dispersion of the capacity over.
        states: Limit states of every component by rising threshold, fitted or not.
        folder: Where the table lies, with the other tables of the study beside it.
    """

    method: str
    rows: pd.DataFrame
    states: dict[str, list[str]]
    folder: Path

    @property
    def fitted(self) -> pd.DataFrame:
        """Curves with an estimate."""
        return self.rows[self.rows["status"] == FITTED]

    @property
    def unfitted(self) -> list[dict[str, str]]:
        """Curves without one: variant, component, limit state and why."""
        left = self.rows.loc[self.rows["status"] != FITTED]
        names = ["variant", "component", "limit_state", "status"]
        return [dict(zip(names, map(str, row), strict=True)) for row in left[names].to_numpy()]

    @property
    def without_capacity(self) -> int:
        """Curves whose dispersion is of the records alone though their capacity has one."""
        return int(self.fitted["beta_total"].isna().sum())


def choose_curves(source: Path, method: str) -> ChosenCurves:
    """Read the curves of one method.

    Args:
        source: results/fragility/curves.parquet, or the same as CSV.
        method: cloud, exceedance, ida_interval or ordered.

    Raises:
        InputError: The table is unreadable, lacks a column, or has no curve of the method.
    """
    table = read_table(source)
    need_columns(table, _NEEDED, source.name)
    rows = table[table["method"] == method]
    if rows.empty:
        known = ", ".join(sorted(table["method"].unique()))
        raise InputError(f"no curves of method {method!r} (known: {known})")
    total = rows["beta_total"].where(rows["beta_total"].notna(), rows["beta"])
    ordered = table.sort_values("threshold", kind="stable")
    return ChosenCurves(
        method=method,
        rows=rows.assign(**{CURVE_BETA: total}).reset_index(drop=True),
        states={
            str(name): list(dict.fromkeys(map(str, ordered.loc[part.index, "limit_state"])))
            for name, part in ordered.groupby("component", sort=False)
        },
        folder=source.parent,
    )

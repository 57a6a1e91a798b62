"""Checks of the products of a study: what a sceptical reader would ask of the tables."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.analysis.rungs import rung_shares
from skewbridge.analysis.suspect import SUSPECT, reasons_in
from skewbridge.demands.columns import KEY
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.statuses import RAN, STATUSES

MIN_USABLE_SHARE: Final = 0.99
_ROUNDING_KJ: Final = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class TableCheck:
    """One check of the tables of a study.

    Attributes:
        name: What is counted or measured.
        value: What was found.
        limit: Largest value that passes, or the least of a share.
        passed: Whether it holds.
    """

    name: str
    value: float
    limit: float
    passed: bool


def check_tables(
    demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame
) -> list[TableCheck]:
    """Return the checks of the three tables of a study: a share, then counts that must be 0."""
    usable = demands["status"].isin(RAN)
    ok = demands[usable]
    runs_per_variant = demands.groupby("variant").size()
    numbers = ok[[column.name for column in DEMAND_COLUMNS if column.name in ok]]
    components = ok[["column_shear_x_kn", "column_shear_y_kn"]].max(axis=1)
    slips = ok["slip_work_kj"].abs() > _ROUNDING_KJ
    fitted = curves[curves["status"] == "ok"]
    bounded = effects[effects["ci_low"].notna()]
    findings: dict[str, pd.Series] = {
        "analyses that stand there twice": demands.duplicated(list(KEY)),
        "rows without a known status": ~demands["status"].isin(STATUSES),
        "variants with fewer motions than others": runs_per_variant != runs_per_variant.max(),
        "usable rows with a demand that is not a number": numbers.isna().any(axis=1),
        "usable rows whose resultant shear is below a component": (
            ok["column_shear_kn"] < components
        ),
        "rows with negative friction work": ok["slip_work_kj"] < -_ROUNDING_KJ,
        "rows with friction work though friction is zero": (ok["friction"] == 0.0) & slips,
        "fitted curves without a positive median": ~(fitted["theta"] > 0),
        "effects whose interval does not hold the ratio": (
            ~bounded["ratio"].between(bounded["ci_low"], bounded["ci_high"])
        ),
    }
    share = float(usable.mean())
    return [
        TableCheck(
            name=f"share of rows with status {' or '.join(RAN)}",
            value=share,
            limit=MIN_USABLE_SHARE,
            passed=share >= MIN_USABLE_SHARE,
        ),
        *(
            TableCheck(name=name, value=float(found.sum()), limit=0.0, passed=not found.any())
            for name, found in findings.items()
        ),
    ]


def suspect_rows(demands: pd.DataFrame) -> list[dict[str, Any]]:
    """Return how many rows are suspect for each reason, and which of them is the worst."""
    return [
        {
            "reason": found["reason"],
            "rows": found["rows"],
            "worst": found["worst"],
            **demands.iloc[found["at"]][list(KEY)].to_dict(),
        }
        for found in reasons_in(demands[SUSPECT])
    ]


def write_checks(*, demands: Path, curves: Path, effects: Path, output: Path) -> None:
    """Check the products of a study and write the findings as JSON.

    With them go the suspect rows by reason, and what each rung of the recovery ladder carried.
    A finding does not stop the workflow: the report shows it at the top.
    """
    table = read_frame(demands)
    checks = check_tables(table, read_frame(curves), read_frame(effects))
    payload = {
        "passed": all(c.passed for c in checks),
        "checks": [asdict(c) for c in checks],
        "suspect_rows": int((table[SUSPECT] != "").sum()),
        "suspect": suspect_rows(table),
        "rungs": rung_shares(table["steps_by_rung"]),
    }
    write_text(output, json.dumps(payload, indent=1))

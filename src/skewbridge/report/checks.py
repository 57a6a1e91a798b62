"""Checks of the products of a study: what a sceptical reader would ask of the tables."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.demands.schema import KEY
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.statuses import STATUSES

USABLE: Final = ("ok", "collapse")
MIN_USABLE_SHARE: Final = 0.99


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One check.

    Attributes:
        name: What must hold, as a sentence.
        value: What was found.
        limit: The limit.
        passed: Whether it holds.
    """

    name: str
    value: float
    limit: float
    passed: bool


def check_tables(demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame) -> list[Check]:
    """Return the checks of the three tables of a study."""
    usable = demands["status"].isin(USABLE)
    runs_per_variant = demands.groupby("variant").size()
    ok = demands[usable]
    numbers = ok.filter(regex="^(column|deck|abutment|bearing|contact|slip)").select_dtypes(
        "number"
    )
    fitted = curves[curves["status"] == "ok"]
    bounded = effects[effects["ci_low"].notna()]
    return [
        _at_most("analyses that stand there twice", demands.duplicated(list(KEY)).sum(), 0),
        _at_most("rows without a known status", (~demands["status"].isin(STATUSES)).sum(), 0),
        _at_least("share of rows with status ok or collapse", usable.mean(), MIN_USABLE_SHARE),
        _at_most(
            "variants with fewer motions than others",
            (runs_per_variant != runs_per_variant.max()).sum(),
            0,
        ),
        _at_most(
            "usable rows with a demand that is not a number", numbers.isna().any(axis=1).sum(), 0
        ),
        _at_most(
            "usable rows whose resultant shear is below a component",
            (
                ok["column_shear_kn"] < ok[["column_shear_x_kn", "column_shear_y_kn"]].max(axis=1)
            ).sum(),
            0,
        ),
        _at_most("rows with negative friction work", (ok["slip_work_kj"] < -1e-6).sum(), 0),
        _at_most(
            "rows with friction work though friction is zero",
            ((ok["friction"] == 0.0) & (ok["slip_work_kj"].abs() > 1e-6)).sum(),
            0,
        ),
        _at_most("fitted curves without a positive median", (~(fitted["theta"] > 0)).sum(), 0),
        _at_most(
            "effects whose interval does not hold the ratio",
            (~bounded["ratio"].between(bounded["ci_low"], bounded["ci_high"])).sum(),
            0,
        ),
    ]


def write_checks(*, demands: Path, curves: Path, effects: Path, output: Path) -> None:
    """Check the products of a study and write the findings as JSON.

    A finding does not stop the workflow: the report shows it at the top.
    """
    checks = check_tables(read_frame(demands), read_frame(curves), read_frame(effects))
    payload = {"passed": all(c.passed for c in checks), "checks": [asdict(c) for c in checks]}
    write_text(output, json.dumps(payload, indent=1))


def _at_most(name: str, value: float, limit: float) -> Check:
    return Check(name=name, value=float(value), limit=limit, passed=bool(value <= limit))


def _at_least(name: str, value: float, limit: float) -> Check:
    return Check(name=name, value=float(value), limit=limit, passed=bool(value >= limit))

"""Checks of the products of a study: what a sceptical reader would ask of the tables."""

import json
import logging
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.analysis.rungs import rung_shares
from skewbridge.analysis.suspect import SUSPECT, reasons_in
from skewbridge.demands.columns import KEY
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.errors import SolutionError
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.twin_rows import contact_twins, mirror_twins
from skewbridge.statuses import RAN, STATUSES

#: So many rows of a failed check are named.
NAMED: Final = 10
_ROUNDING_KJ: Final = 1e-6
#: Medians of two states that the same analyses exceed may be equal.
_EQUAL_MEDIANS: Final = 1e-9
_CURVE_NAME: Final = ("variant", "component", "limit_state", "method")
_EFFECT_NAME: Final = ("variant", "bridge", "abutment", "axis", "from_value", "to_value", "demand")

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class TableCheck:
    """One check of the tables of a study.

    Attributes:
        name: What is counted or measured.
        value: What was found.
        limit: Largest value that passes.
        passed: Whether it holds.
        rows: Names of the rows that do not pass, the first `NAMED` of them.
    """

    name: str
    value: float
    limit: float
    passed: bool
    rows: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyTables:
    """The tables that are checked, and what was asked of them.

    Attributes:
        demands: All rows of the study.
        curves: Its fits.
        effects: Its paired effects.
        suite: Its motions with their accelerations.
        max_unfinished_share: Largest share of rows without a usable result that passes.
        cohesion_n: Cohesion at the backwalls, unless it is an axis of the grid.
        searched: Whether each motion was searched for a capacity (IDA): variants have as many
            searches then, but not as many analyses.
    """

    demands: pd.DataFrame
    curves: pd.DataFrame
    effects: pd.DataFrame
    suite: pd.DataFrame
    max_unfinished_share: float
    cohesion_n: float = 0.0
    searched: bool = False


def check_tables(tables: StudyTables) -> list[TableCheck]:
    """Return the checks of a study: the share not finished, then counts that must be 0."""
    demands, curves, effects = tables.demands, tables.curves, tables.effects
    finished = demands["status"].isin(RAN)
    ok = demands[finished]
    planned = ["variant", "motion_id", "incidence_deg"] if tables.searched else list(KEY)
    per_variant = demands.drop_duplicates(planned)["variant"].value_counts()
    numbers = ok[[column.name for column in DEMAND_COLUMNS if column.name in ok]]
    components = ok[["column_shear_x_kn", "column_shear_y_kn"]].max(axis=1)
    cohesion_n = ok.get("cohesion_n", pd.Series(tables.cohesion_n, index=ok.index))
    loose = (ok["friction"] == 0.0) & (cohesion_n == 0.0)
    fitted = curves[curves["status"] == "ok"]
    bounded = effects[effects["ci_low"].notna()]
    unfinished = demands[~finished]
    share = len(unfinished) / max(len(demands), 1)
    return [
        TableCheck(
            name=f"share of rows with a status other than {' or '.join(RAN)}",
            value=share,
            limit=tables.max_unfinished_share,
            passed=share <= tables.max_unfinished_share,
            rows=_names(unfinished, (*KEY, "status")),
        ),
        _none("analyses that stand there twice", demands[demands.duplicated(list(KEY))], KEY),
        _none("rows without a known status", demands[~demands["status"].isin(STATUSES)], KEY),
        _none(
            "rows of variants with fewer analyses than others",
            demands[demands["variant"].map(per_variant) != per_variant.max()],
            KEY,
        ),
        _none(
            "finished rows with a demand that is not a number", ok[numbers.isna().any(axis=1)], KEY
        ),
        _none(
            "finished rows whose resultant shear is below a component",
            ok[ok["column_shear_kn"] < components],
            KEY,
        ),
        _none("rows with negative friction work", ok[ok["slip_work_kj"] < -_ROUNDING_KJ], KEY),
        _none(
            "rows with friction work though nothing rubs",
            ok[loose & (ok["slip_work_kj"].abs() > _ROUNDING_KJ)],
            KEY,
        ),
        _none("rows without friction that differ from contact", contact_twins(ok[loose], ok), KEY),
        _none("rows that differ from their mirror image", mirror_twins(ok, tables.suite), KEY),
        _none(
            "fitted curves without a positive median", fitted[~(fitted["theta"] > 0)], _CURVE_NAME
        ),
        _none("medians below that of a smaller capacity", falling_medians(fitted), _CURVE_NAME),
        _none(
            "effects whose interval does not hold the ratio",
            bounded[~bounded["ratio"].between(bounded["ci_low"], bounded["ci_high"])],
            _EFFECT_NAME,
        ),
    ]


def falling_medians(fitted: pd.DataFrame) -> pd.DataFrame:
    """Return the fitted curves whose median is below that of a smaller capacity.

    Compared are the states of one demand of a component, by the same method in the same variant.
    """
    ordered = fitted.sort_values("threshold", kind="stable")
    groups = [ordered[name] for name in ("variant", "component", "method", "demand")]
    before = ordered.groupby(groups)["theta"].cummax().groupby(groups).shift()
    return ordered[ordered["theta"] < before * (1.0 - _EQUAL_MEDIANS)]


def _none(name: str, found: pd.DataFrame, named_by: Sequence[str]) -> TableCheck:
    """Return the check that nothing was found."""
    return TableCheck(
        name=name,
        value=float(len(found)),
        limit=0.0,
        passed=found.empty,
        rows=_names(found, named_by),
    )


def _names(found: pd.DataFrame, named_by: Sequence[str]) -> tuple[str, ...]:
    told = found[[name for name in named_by if name in found]].head(NAMED)
    return tuple(
        ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in row)
        for row in told.itertuples(index=False)
    )


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


def write_checks(tables: StudyTables, output: Path, *, strict: bool) -> None:
    """Check the products of a study and write the findings as JSON.

    With them go the suspect rows by reason, and what each rung of the recovery ladder carried.
    What fails is logged with its rows, and the report shows it at the top.

    Args:
        tables: The products.
        output: The JSON file.
        strict: Whether a check that fails stops the workflow.

    Raises:
        SolutionError: A check failed, and that stops the workflow.
    """
    checks = check_tables(tables)
    failed = [check for check in checks if not check.passed]
    for check in failed:
        logger.warning("%s: %.4g > %.4g", check.name, check.value, check.limit)
        for row in check.rows:
            logger.warning("    %s", row)
    demands = tables.demands
    payload = {
        "passed": not failed,
        "checks": [asdict(check) for check in checks],
        "suspect_rows": int((demands[SUSPECT] != "").sum()),
        "suspect": suspect_rows(demands),
        "rungs": rung_shares(demands["steps_by_rung"]),
    }
    write_text(output, json.dumps(payload, indent=1))
    if failed and strict:
        raise SolutionError(
            f"{len(failed)} of {len(checks)} checks of the tables failed (checks: strict): "
            + "; ".join(check.name for check in failed)
        )


def read_tables(
    *, demands: Path, curves: Path, effects: Path, suite: Path, **asked: Any
) -> StudyTables:
    """Return the tables to be checked from their files.

    Args:
        demands: All rows of the study.
        curves: Its fits.
        effects: Its paired effects.
        suite: Its motions.
        **asked: ``max_unfinished_share``, ``cohesion_n`` and ``searched`` of `StudyTables`.
    """
    return StudyTables(
        demands=read_frame(demands),
        curves=read_frame(curves),
        effects=read_frame(effects),
        suite=read_frame(suite),
        **asked,
    )

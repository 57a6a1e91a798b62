"""Checks of the tables of a study: completeness, plausibility and known invariances."""

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.analysis.recovery import recovery_shares, steps_from_text
from skewbridge.demands.columns import DEMAND_COLUMNS, KEY
from skewbridge.demands.validity import SUSPECT, count_reasons, is_beyond_model
from skewbridge.errors import SolutionError
from skewbridge.files.tables import Row
from skewbridge.files.text import write_text
from skewbridge.statuses import RAN, STATUSES
from skewbridge.variant.axes import axes_of
from skewbridge.variant.variant import ABUTMENTS

#: Both models have equal equations, numbering and springs; updates at zero friction do nothing.
CONTACT_TOLERANCE: Final = 1e-9
#: Demands below this limit (in their units) count as zero.
_CONTACT_NOTHING: Final = 1e-12
#: Number of rows that a failed check lists.
NAMED: Final = 10
_ROUNDING_KJ: Final = 1e-6
_CURVE_NAME: Final = ("variant", "component", "limit_state", "method")
_EFFECT_NAME: Final = ("variant", "bridge", "abutment", "axis", "from_value", "to_value", "demand")

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyTables:
    """The tables to check, and settings of the study that the checks need."""

    demands: pd.DataFrame
    curves: pd.DataFrame
    effects: pd.DataFrame
    max_failed_share: float = 0.01  # of rows without a usable result; more do not pass
    cohesion_n: float = 0.0  # cohesion at the backwalls, unless it is an axis of the grid
    #: Number of analyses of each variant; a variant that is not listed has as many as any other.
    planned: Mapping[str, int] = field(default_factory=dict[str, int])
    searched: bool = False  # IDA: searches are counted, not analyses
    in_rounds: bool = False  # variants took part in different numbers of rounds


def check_tables(tables: StudyTables) -> list[Row]:
    """Return the checks of a study: the share of failed rows, then counts that must be 0.

    Each check has name, value, limit (the largest value that passes), passed, and rows (the names
    of the first `NAMED` rows found).
    """
    demands, curves, effects = tables.demands, tables.curves, tables.effects
    finished = demands["status"].isin(RAN)
    ok, failed = demands[finished], demands[~finished & ~is_beyond_model(demands)]
    planned = ["variant", "motion_id", "incidence_deg"] if tables.searched else list(KEY)
    per_variant = demands.drop_duplicates(planned)["variant"].value_counts()
    expected = demands["variant"].map(tables.planned).fillna(per_variant.max())
    is_uneven = (demands["variant"].map(per_variant) != expected) & (not tables.in_rounds)
    values = ok[[column.name for column in DEMAND_COLUMNS if column.name in ok]]
    if "support_length_m" in ok:  # empty for a bridge without a seat, which cannot unseat
        no_seat, names = ok["support_length_m"].isna(), ["unseating_m", "acute_corner_unseating_m"]
        values = values.assign(**{name: values[name].mask(no_seat, 0.0) for name in names})
    components = ok[["column_shear_x_kn", "column_shear_y_kn"]].max(axis=1)
    cohesion_n = ok.get("cohesion_n", pd.Series(tables.cohesion_n, index=ok.index))
    smooth = (ok["friction"] == 0.0) & (cohesion_n == 0.0)
    fitted = curves[curves["status"] == "ok"]
    estimated = effects[effects["ci_low"].notna()]
    is_within = estimated["ratio"].between(estimated["ci_low"], estimated["ci_high"])
    # a bridge without a stated capacity of its columns has no such demand in any row
    is_demand_of_bridge = values.notna().groupby(ok["bridge"]).transform("any")
    is_missing = values.isna() & is_demand_of_bridge
    below_component, work_kj = ok[ok["column_shear_kn"] < components], ok["slip_work_kj"]
    share = len(failed) / max(len(demands), 1)
    # states of the same variant, component, demand and method
    ordered = fitted.sort_values("threshold", kind="stable")
    groups = [ordered[name] for name in ("variant", "component", "method", "demand")]
    milder_median = ordered.groupby(groups)["theta"].cummax().groupby(groups).shift()
    # two states exceeded by the same analyses may have equal medians
    falling = ordered[ordered["theta"] < milder_median * (1.0 - 1e-9)]
    checks: tuple[Any, ...] = (
        ("share of rows that failed before the end of the motion, a collapse or a column failure",
         failed, (*KEY, "status"), share, tables.max_failed_share),
        ("analyses listed twice", demands[demands.duplicated(list(KEY))], KEY),
        ("rows without a known status", demands[~demands["status"].isin(STATUSES)], KEY),
        ("rows of variants with fewer analyses than planned", demands[is_uneven], KEY),
        ("finished rows with a demand that is not a number", ok[is_missing.any(axis=1)], KEY),
        ("finished rows whose resultant shear is below a component", below_component, KEY),
        ("rows with negative friction work", ok[work_kj < -_ROUNDING_KJ], KEY),
        ("rows with friction work but without friction",
         ok[smooth & (work_kj.abs() > _ROUNDING_KJ)], KEY),
        ("rows that differ from the frictionless model", contact_differences(ok[smooth], ok), KEY),
        ("fitted curves without a positive median", fitted[~(fitted["theta"] > 0)], _CURVE_NAME),
        ("medians below the median of a smaller capacity", falling, _CURVE_NAME),
        ("effects whose interval does not contain the ratio", estimated[~is_within], _EFFECT_NAME),
    )  # fmt: skip
    return [_check(*check) for check in checks]


def _check(name: str, rows_found: pd.DataFrame, named_by: Sequence[str], *share: float) -> Row:
    """Return a check of the number of rows found (which must be 0) or of a share and its limit."""
    value, limit = share or (float(len(rows_found)), 0.0)
    examples = rows_found[[name for name in named_by if name in rows_found]].head(NAMED)
    rows = [
        ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in row)
        for row in examples.itertuples(index=False)
    ]
    return {"name": name, "value": value, "limit": limit, "passed": value <= limit, "rows": rows}


def write_checks(tables: StudyTables, output: Path) -> None:
    """Check the tables of a study and write the checks as JSON.

    The file also lists the reasons of suspect rows and the time steps of each recovery step.
    Failed checks are logged with their rows, and the report shows them at the top.
    """
    checks = check_tables(tables)
    failed = [check for check in checks if not check["passed"]]
    for check in failed:
        logger.warning(
            "check failed: %s: %.4g, limit %.4g", check["name"], check["value"], check["limit"]
        )
        for row in check["rows"]:
            logger.warning("    %s", row)
    demands = tables.demands
    payload = {
        "passed": not failed,
        "checks": checks,
        "suspect_rows": int((demands[SUSPECT] != "").sum()),
        "suspect": [
            {name: suspect[name] for name in ("reason", "rows", "worst")}
            | demands.iloc[suspect["at"]][list(KEY)].to_dict()
            for suspect in count_reasons(demands[SUSPECT])
        ],
        "rungs": recovery_shares(map(steps_from_text, demands["steps_by_rung"])),
    }
    write_text(output, json.dumps(payload, indent=1))


def require_passed(checks: Path) -> None:
    """Raise `SolutionError` if a check in a file of `write_checks` failed (``checks: strict``)."""
    all_checks = json.loads(checks.read_text(encoding="utf-8"))["checks"]
    failed = [check["name"] for check in all_checks if not check["passed"]]
    if failed:
        raise SolutionError(
            f"{len(failed)} of {len(all_checks)} checks of the tables failed (checks: strict): "
            + "; ".join(failed)
        )


def contact_differences(frictionless: pd.DataFrame, ok: pd.DataFrame) -> pd.DataFrame:
    """Return rows with zero friction that differ from the same run of the frictionless model.

    ``frictionless`` are rows with zero friction and cohesion, of any abutment model; ``ok`` are the
    finished rows of the study.
    """
    models = {traits.without_friction: name for name, traits in ABUTMENTS.items()}
    zero_friction = ok.assign(abutment=ok["abutment"].map(models)).dropna(subset="abutment")
    axes = [axis.name for axis in axes_of(ok.columns) if axis.name != "friction"]
    names = [column.name for column in DEMAND_COLUMNS if column.name in ok]
    keys = ["bridge", "abutment", *axes, "motion_id", "scale", "incidence_deg"]
    joined = frictionless.merge(zero_friction, on=keys, suffixes=("", "_other"))
    others = [f"{name}_other" for name in names]
    frictionless_values, other_values = (joined[n].to_numpy(float) for n in (names, others))
    limits = {"rtol": CONTACT_TOLERANCE, "atol": _CONTACT_NOTHING}
    is_equal = np.isclose(frictionless_values, other_values, equal_nan=True, **limits)
    return joined[~is_equal.all(axis=1)]

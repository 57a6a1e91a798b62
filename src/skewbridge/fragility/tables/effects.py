"""Paired effects of the axes of a study: ratios of demand under the same motions.

The record-to-record scatter cancels in the ratio of one motion's demands, so a few per cent are
seen with 16 motions where an unpaired comparison would need hundreds.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL, is_beyond_model, is_complete
from skewbridge.fragility.tables.key_columns import (
    BRIDGE_COLUMNS,
    KEY_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    need_columns,
)
from skewbridge.statuses import COLLAPSE
from skewbridge.variant.axes import AXES, Axis, axes_of

NEGLIGIBLE: Final = "negligible"
MATTERS: Final = "matters"
UNDECIDED: Final = "undecided"
MAX_DISCORDANT: Final = 0.05
_MIN_MOTIONS: Final = 3
MIN_BOOTSTRAP: Final = 8  # motions; below, Student's t instead of the bootstrap


def effect_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return names and meanings of the columns of the effects of a study with these axes."""
    return {
        "bridge": "catalogue entry",
        "abutment": "abutment model",
        "demand": "demand column, or component/limit_state for a median capacity",
        "quantity": "demand | median_capacity",
        "axis": " | ".join(axis.name for axis in axes),
        "from_value": "value of the axis in the denominator",
        "to_value": "value of the axis in the numerator",
        **{
            axis.name: f"{axis.title} of both variants; NaN where it is the axis or pooled over"
            for axis in axes
        },
        "scope": "variant (one pair of variants) | pooled (all pairs, motion by motion)",
        "ratio": "geometric mean over the motions of the paired ratio",
        "from_mean": "geometric mean of the demand at from_value: how large it is at all",
        "ci_low": "lower end of its interval (bootstrap-t over motions; Student's t below 8)",
        "ci_high": "upper end",
        "level": "confidence level",
        "margin": "relative change that counts as negligible",
        "n_motions": "motions with a usable pair",
        "n_left_out": "pairs left out: a run collapsed, failed or went beyond the model, or a "
        "demand is zero",
        "n_discordant": "of these, pairs in which one side alone collapsed, failed, went beyond "
        "the model or is zero",
        "n_beyond_model": "of these, pairs in which a column failed beyond the model",
        "n_collapse_from": "collapsed runs at from_value",
        "n_collapse_to": "collapsed runs at to_value",
        "verdict": "negligible (interval inside the margin) | matters (outside it) | undecided",
    }


EFFECT_COLUMNS: Final = effect_columns(AXES)


def verdict_of(ci_low: float, ci_high: float, margin: float = DEFAULTS.margin) -> str:
    """Judge an interval of a ratio against 1 - margin .. 1 + margin.

    ``negligible``: inside; ``matters``: wholly outside; ``undecided``: neither, or no interval.

    References:
        Schuirmann (1987), J. Pharmacokin. Biopharm. 15(6):657-680: two one-sided tests.
    """
    if np.isnan(ci_low) or np.isnan(ci_high):
        return UNDECIDED
    if ci_low >= 1.0 - margin and ci_high <= 1.0 + margin:
        return NEGLIGIBLE
    return MATTERS if ci_low > 1.0 + margin or ci_high < 1.0 - margin else UNDECIDED


def paired_effects(
    demands: pd.DataFrame,
    columns: Sequence[str] | None = None,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return the paired ratios of demand along every axis of a study.

    Two variants that differ in one axis only are paired run by run (same motion, scale and
    incidence). The ratio is the geometric mean over motions (a motion counts once, however often
    it ran); the smallest value of the axis is the reference. Pairs in which a run collapsed,
    failed or went beyond the model, or a demand is zero, have no ratio: they are left out and
    counted.

    By default the demand columns are those with the role ``effect`` that the table has.

    Returns:
        Rows with the columns `effect_columns`, per pair of variants and pooled over them.

    Raises:
        InputError: A column is missing, or a run occurs twice.
    """
    names = list(demands_for("effect", demands.columns) if columns is None else columns)
    need_columns(demands, (*KEY_COLUMNS, *names))
    rows = [
        pair | {"demand": name, "quantity": "demand"} | _effect(part, name, settings)
        for pair, part in pair_groups(demands, names, scopes=("variant", "pooled"))
        for name in names
    ]
    return effect_table(demands, rows)


def effect_table(demands: pd.DataFrame, rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Return rows of effects as a table with the columns of the axes of the study."""
    return pd.DataFrame(rows, columns=list(effect_columns(axes_of(map(str, demands.columns)))))


def pair_groups(
    demands: pd.DataFrame, columns: Sequence[str], *, scopes: Sequence[str] = ("variant",)
) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield the pairs of runs along each axis, together per pair of variants or pooled over them.

    Scopes are ``variant`` and ``pooled``; ``columns`` are those whose values are paired.

    Yields:
        Axis, scope, bridge, abutment, from_value, to_value and the other axes; and the pairs of
        `run_pairs`.
    """
    names = axis_names(demands)
    for axis in names:
        pairs = run_pairs(demands, axis, columns)
        ends = [*BRIDGE_COLUMNS, "from_value", "to_value"]
        others = [name for name in names if name != axis]
        for scope in scopes:
            keys = [*ends, *others] if scope == "variant" else ends
            for key, part in pairs.groupby(keys, sort=True, dropna=False):
                yield {"axis": axis, "scope": scope} | dict(zip(keys, key, strict=True)), part


def run_pairs(demands: pd.DataFrame, axis: str, columns: Sequence[str]) -> pd.DataFrame:
    """Pair the runs of variants that differ in ``axis`` only.

    Returns:
        One row per pair: bridge, abutment, the other axes, motion_id, from_value, to_value,
        status, beyond_model and complete (truth values) and the demands with ``_from`` and
        ``_to``.

    Raises:
        InputError: A run occurs twice.
    """
    group = [*BRIDGE_COLUMNS, *(name for name in axis_names(demands) if name != axis)]
    key = [*group, *LOADING_COLUMNS]
    table = demands[[*key, axis, "status", *columns]].assign(
        **{BEYOND_MODEL: is_beyond_model(demands), "complete": is_complete(demands)}
    )
    once = ~table.duplicated([*key, axis]).to_numpy()
    if not once.all():
        row = int(np.argmin(once))
        raise InputError(f"the run of row {row} occurs twice in the demands table", row=row)
    lowest = table.groupby(group, dropna=False)[axis].transform("min")
    reference = table[table[axis] == lowest].rename(columns={axis: "from_value"})
    others_rows = table[table[axis] > lowest].rename(columns={axis: "to_value"})
    return others_rows.merge(reference, on=key, suffixes=("_to", "_from"), validate="many_to_one")


def _effect(part: pd.DataFrame, name: str, settings: FitSettings) -> dict[str, Any]:
    top, bottom, usable = usable_pairs(part, name)
    usable &= np.isfinite(top) & np.isfinite(bottom)
    discordant = ended_apart(part) | ((top > 0.0) != (bottom > 0.0))
    logs = pd.Series(np.log(top[usable] / bottom[usable]))
    motions = part["motion_id"].to_numpy()[usable]
    # sorted by motion, so that the result does not depend on the order of the rows
    per_motion = logs.groupby(motions).mean().sort_index().to_numpy()
    mean, low, high = studentised_interval(per_motion, settings)
    return {
        "ratio": float(np.exp(mean)),
        "from_mean": float(np.exp(np.mean(np.log(bottom[usable])))) if np.any(usable) else nan,
        "ci_low": float(np.exp(low)),
        "ci_high": float(np.exp(high)),
        "level": settings.effect_confidence,
        "margin": settings.margin,
        "n_motions": int(per_motion.size),
        "n_discordant": int(np.sum(discordant)),
        **pair_counts(part, usable),
        "verdict": paired_verdict(low, high, float(np.mean(discordant)), settings.margin),
    }


def usable_pairs(part: pd.DataFrame, name: str) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Return a demand at to_value and at from_value, and the pairs in which both are usable."""
    top, bottom = (part[f"{name}_{end}"].to_numpy(dtype=np.float64) for end in ("to", "from"))
    finished = (part["complete_to"] & part["complete_from"]).to_numpy()
    return top, bottom, finished & (top > 0.0) & (bottom > 0.0)


def ended_apart(part: pd.DataFrame) -> NDArray[np.bool_]:
    """Return the pairs of which one side alone collapsed, failed or went beyond the model."""
    return np.logical_or.reduce(
        [part[f"{name}_to"] != part[f"{name}_from"] for name in ("status", BEYOND_MODEL)]
    )


def pair_counts(part: pd.DataFrame, usable: NDArray[np.bool_]) -> dict[str, int]:
    """Return how many pairs were left out, how many for a failed column, and the collapses."""
    beyond = part[f"{BEYOND_MODEL}_to"] | part[f"{BEYOND_MODEL}_from"]
    return {
        "n_beyond_model": int(beyond.sum()),
        "n_left_out": int(np.sum(~usable)),
        "n_collapse_from": int((part["status_from"] == COLLAPSE).sum()),
        "n_collapse_to": int((part["status_to"] == COLLAPSE).sum()),
    }


def paired_verdict(ln_low: float, ln_high: float, discordant: float, margin: float) -> str:
    """Judge an interval of ln ratio; never ``negligible`` where many pairs have no ratio.

    ``discordant`` is the share of the pairs in which one side alone has no demand to compare,
    ``margin`` the relative change that counts as negligible.
    """
    found = verdict_of(float(np.exp(ln_low)), float(np.exp(ln_high)), margin)
    # ASSUME ratios of the other pairs say nothing about those in which one side has none
    return UNDECIDED if found == NEGLIGIBLE and discordant > MAX_DISCORDANT else found


@lru_cache(maxsize=8)
def _draws(n: int, replicates: int, seed: int) -> FloatArray:
    """Return how often each of n motions enters each replicate (the same draws for every pair)."""
    rng = np.random.default_rng(seed)
    return rng.multinomial(n, np.full(n, 1.0 / n), size=replicates).astype(np.float64)


def studentised_interval(values: FloatArray, settings: FitSettings) -> tuple[float, float, float]:
    """Return mean and bootstrap-t interval of the mean of values, one per motion.

    The motion is the unit that is drawn; below 8 motions Student's interval is given. The plain
    percentile interval is too narrow with 16 motions; the studentised one is second-order
    correct.

    References:
        Efron and Tibshirani (1993), An Introduction to the Bootstrap, section 12.5.
    """
    n = values.size
    if n == 0:
        return nan, nan, nan
    mean = float(np.mean(values))
    if n < _MIN_MOTIONS:
        return mean, nan, nan
    error = float(np.std(values, ddof=1)) / np.sqrt(n)
    if error < 1e-14:  # the axis has no effect at all on this demand
        return mean, mean, mean
    tail = 0.5 * (1.0 - settings.effect_confidence)
    if n < MIN_BOOTSTRAP:  # too few distinct draws
        reach = float(special.stdtrit(n - 1, 1.0 - tail)) * error
        return mean, mean - reach, mean + reach
    counts = _draws(n, settings.bootstrap, settings.seed)
    means = counts @ values / n
    variances = np.maximum(counts @ values**2 / n - means**2, 0.0) * n / (n - 1)
    errors = np.sqrt(variances / n)
    good = errors > 1e-3 * error  # replicates of (nearly) one motion have no scale
    t = (means[good] - mean) / errors[good]
    t_low, t_high = np.quantile(t, [tail, 1.0 - tail])
    return mean, mean - float(t_high) * error, mean - float(t_low) * error

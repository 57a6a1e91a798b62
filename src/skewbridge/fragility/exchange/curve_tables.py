"""Curves as plain tables: parameters, probabilities over intensities, factors of skew, frequencies.

References:
    FEMA (2022), Hazus 6.1 earthquake technical manual, section 7: the medians of bridges have the
    factor K_skew = sqrt(sin(90 deg - skew)).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.chosen import CURVE_BETA, ChosenCurves
from skewbridge.fragility.exchange.data_files import read_table
from skewbridge.fragility.exchange.risk import annual_frequency
from skewbridge.fragility.tables.key_columns import axis_names, need_columns, variant_columns

_COLUMNS: Final = (
    "component", "limit_state", "method", "im", "theta", "theta_low", "theta_high", "beta_total",
    "beta", "beta_low", "beta_high", "ci_method", "level", "status", "warnings", "n_exceed",
    "n_runs", "n_records", "n_unknown",
)  # fmt: skip
_WIDE: Final = ("theta", "theta_low", "theta_high", "beta_total", "beta")
_SKEW: Final = "skew_deg"


@dataclass(frozen=True, slots=True)
class Sampling:
    """Where curves are evaluated.

    Attributes:
        low: Smallest intensity, in the unit of the measure.
        high: Largest.
        count: Number of intensities, evenly spaced by their logarithm.
    """

    low: float
    high: float
    count: int = 50

    def __post_init__(self) -> None:
        if not (0.0 < self.low < self.high < float("inf") and self.count > 1):
            raise InputError(
                f"the range of intensities must rise above 0, with two points or more: got "
                f"{self.low:g} to {self.high:g}, {self.count} points"
            )


def parameter_table(
    curves: ChosenCurves, *, hazard: Path | None = None, wide: bool = False
) -> pd.DataFrame:
    """Return theta, beta_total (of the curve) and beta (record-to-record), a row per curve.

    Args:
        curves: The curves; those without an estimate have their status.
        hazard: CSV with im and rate (per year): adds annual frequencies within its range, and what
            lies outside.
        wide: A row per variant, columns named component.state.parameter.
    """
    rows = curves.rows
    names = [c for c in (*variant_columns(rows), *_COLUMNS) if c in rows]
    added: list[str] = []
    if hazard is not None:
        found = _frequencies(curves.fitted, hazard)
        rows, added = rows.assign(**found), list(found)
    if wide:
        return _by_variant(rows, [*(c for c in _WIDE if c in rows), *added])
    return rows[[*names, *added]]


def sampled_table(curves: ChosenCurves, at: Sampling, *, wide: bool = False) -> pd.DataFrame:
    """Return the probability of every fitted curve over a range of intensities.

    Args:
        curves: The curves.
        at: Where.
        wide: A row per intensity, a column variant.component.state per curve; otherwise a row per
            curve and intensity.
    """
    fitted = curves.fitted
    im = np.geomspace(at.low, at.high, at.count)
    u = (np.log(im) - np.log(fitted["theta"].to_numpy())[:, None]) / (
        fitted[CURVE_BETA].to_numpy()[:, None]
    )
    p = special.ndtr(u)
    if wide:
        keys = fitted[["variant", "component", "limit_state"]].astype(str)
        named = dict(zip(keys.agg(".".join, axis=1), p, strict=True))
        return pd.DataFrame({_one_measure(fitted): im, **named})
    names = [*variant_columns(fitted), "component", "limit_state", "method", "im"]
    long = fitted[names].loc[fitted.index.repeat(at.count)].reset_index(drop=True)
    return long.assign(intensity=np.tile(im, len(fitted)), probability=p.ravel())


def skew_factors(curves: ChosenCurves) -> pd.DataFrame:
    """Return theta(skew) / theta(0) of variants alike but for their skew, beside that of Hazus.

    Raises:
        InputError: The study has no variants at skew 0 and another one with estimates.
    """
    fitted = curves.fitted
    others = [name for name in axis_names(fitted) if name != _SKEW]
    keys = ["bridge", "abutment", *others, "component", "limit_state"]
    straight = fitted.loc[fitted[_SKEW] == 0, [*keys, "theta"]]
    skewed = fitted.loc[fitted[_SKEW] != 0, [*keys, _SKEW, "im", "theta"]]
    both = skewed.merge(straight, on=keys, suffixes=("", "_straight"))
    if both.empty:
        raise InputError("no limit state has an estimate both at skew 0 and at another skew")
    angle = np.radians(90.0 - both[_SKEW].abs().to_numpy(dtype=np.float64))
    return both.assign(
        factor=both["theta"] / both["theta_straight"], hazus_factor=np.sqrt(np.sin(angle))
    )[[*keys, _SKEW, "im", "theta", "theta_straight", "factor", "hazus_factor"]]


def hazard_notes(table: pd.DataFrame, hazard: Path) -> list[str]:
    """Return in words over which intensities frequencies count, and how much lies outside."""
    levels = read_table(hazard)["im"]
    known = table.dropna(subset=["annual_frequency"])
    if known.empty:
        return ["no curve has an estimate: no annual frequency"]
    most = (known["annual_frequency_above_most"] / known["annual_frequency"]).max()
    least = (known["annual_frequency_above_least"] / known["annual_frequency"]).max()
    start = known["probability_at_first_level"].max()
    return [
        f"annual frequencies are of intensities from {levels.iloc[0]:g} to {levels.iloc[-1]:g}, "
        f"the range of {hazard.name}; those above add up to {most:.1%} (at least {least:.1%}) "
        f"to a curve; at the first level a curve is at {start:.1%} at most"
    ]


def _by_variant(rows: pd.DataFrame, values: list[str]) -> pd.DataFrame:
    keys = variant_columns(rows)
    table = rows[keys].drop_duplicates("variant").reset_index(drop=True)
    columns: dict[str, Any] = {}
    for (component, state), part in rows.groupby(["component", "limit_state"], sort=False):
        own = part.set_index("variant").reindex(table["variant"])
        columns |= {f"{component}.{state}.{name}": own[name].to_numpy() for name in values}
    return pd.concat([table, pd.DataFrame(columns)], axis=1)


def _one_measure(rows: pd.DataFrame) -> str:
    measures = rows["im"].unique()
    if len(measures) != 1:
        raise InputError(f"one range cannot serve the measures {', '.join(map(str, measures))}")
    return str(measures[0])


def _frequencies(fitted: pd.DataFrame, hazard: Path) -> dict[str, pd.Series]:
    """Return annual frequency and probability in 50 years of the curves that have an estimate.

    Both are of the range of the hazard table; beside them stand what the intensities above its last
    level add at least and at most, and the probability at its first, below which nothing counts.
    """
    table = read_table(hazard)
    need_columns(table, ("im", "rate"), hazard.name)
    _one_measure(fitted)
    found = [
        annual_frequency(theta, beta, table["im"].to_numpy(), table["rate"].to_numpy())
        for theta, beta in zip(fitted["theta"], fitted[CURVE_BETA], strict=True)
    ]
    values = {
        "annual_frequency": [item.frequency for item in found],
        "probability_50y": [item.probability_50y for item in found],
        "annual_frequency_above_least": [item.above_least for item in found],
        "annual_frequency_above_most": [item.above for item in found],
        "probability_at_first_level": [item.below for item in found],
    }
    return {name: pd.Series(column, index=fitted.index) for name, column in values.items()}

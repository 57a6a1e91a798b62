"""Effects of skew that others published, against ours on the same quantities.

PEER's bridges A, B and C run at the skews of `SKEWS_DEG` under the same motions. The effect on a
median capacity is compared with the factor of Hazus; effects on demands with the directions that
others report (docs/theory/published_skew.md). `CHOICES` change one modelling choice in bridge B and
give the effect of skew with it.

References:
    FEMA (2022), Hazus 6.1, section 7: medians have the factor sqrt(sin(90 deg - skew)).
    Kaviani, Zareian and Taciroglu, PEER 2014/01.
"""

from collections.abc import Mapping
from itertools import product
from math import exp, radians, sin, sqrt
from typing import Any, Final

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import t as student

from skewbridge.files.tables import records_of
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.effects import median_effects
from skewbridge.statuses import OK, RAN
from skewbridge.verification.studies import figure_style as style
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.published import (
    DEMANDS,
    SETTINGS,
    WHOLE,
    analysed_demands,
    capacities,
    published_curves,
    study_variant,
)

BRIDGES: Final = ("bridge_a", "bridge_b", "bridge_c")
SKEWS_DEG: Final = (0, 30, 60)
MOTIONS: Final = 12
CHOICE_MOTIONS: Final = 8
LEVEL: Final = 0.90
HAZUS: Final = "Hazus: sqrt(sin(90 deg - skew))"
#: Demands that others report effects of skew on.
COMPARED: Final = (
    "column_drift_ratio",
    "column_shear_dcr",
    "deck_disp_m",
    "deck_rotation_rad",
    "unseating_m",
    "abutment_transverse_m",
    "abutment_passive_m",
)
#: Modelling choices that may change the effect of skew, and the bridge that they are tried on. The
#: first changes nothing: the effect under the motions of the others.
CHOICES: Final[Mapping[str, Mapping[str, Any]]] = {
    "as above": {},
    "key faces along the abutment line": {"key_frame": "skewed"},
    "keys that do not break": {"keys": "monolithic"},
    "backfill stronger at the acute corner": {"backfill_variation": 0.3},
}
CHOSEN: Final = "bridge_b"
#: Options that change nothing without skew.
ONLY_SKEWED: Final = {"key_frame", "backfill_variation"}


def run(study: Study) -> None:
    """Run the bridges at their skews and one bridge with other choices; report the effects."""
    plain = {
        (bridge, skew, "none"): (study_variant(bridge, skew), {})
        for bridge in BRIDGES
        for skew in SKEWS_DEG
    }
    changed = {
        (CHOSEN, skew, choice): (study_variant(CHOSEN, skew), options)
        for choice, options in CHOICES.items()
        for skew in (SKEWS_DEG[0], SKEWS_DEG[-1])
        if skew or not ONLY_SKEWED & options.keys()
    }
    demands = analysed_demands(study, plain, MOTIONS)
    straight = demands[CHOSEN, 0, "none"].head(CHOICE_MOTIONS)
    demands |= analysed_demands(study, changed, CHOICE_MOTIONS)
    for choice in CHOICES:
        demands.setdefault((CHOSEN, 0, choice), straight)
    table = pd.concat(
        [
            part.assign(bridge=bridge, skew_deg=skew, choice=choice)
            for (bridge, skew, choice), part in demands.items()
        ],
        ignore_index=True,
    )
    ratios = demand_ratios(table)
    medians = median_factors(table)
    study.tables["demands"], study.tables["medians"] = ratios, medians
    for row in records_of(ratios[ratios["demand"] != "deck_rotation_rad"]):
        text = f"{_case(row)}: {row['demand']}, ratio to skew 0 {_interval(row)}"
        study.report(text, row["ratio"], 1.0, "skew 0, same motions")
    for row in records_of(medians):
        text = f"{_case(row)}: median of {row['demand']}, factor {_interval(row)}"
        study.report(text, row["ratio"], hazus_factor(row["skew_deg"]), HAZUS)
    for (bridge, skew, choice), part in demands.items():
        done = int((part["status"].isin(RAN)).sum())
        text = f"{bridge}, skew {skew}, choice {choice}: analyses that ended ok or in collapse"
        study.absolute(text, done, len(part), 0.0, "every analysis")
    study.figures["medians"] = _figure(medians)


def hazus_factor(skew_deg: float) -> float:
    """Return the factor of Hazus on the medians of a skewed bridge."""
    return sqrt(sin(radians(90.0 - abs(skew_deg))))


def demand_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Return the mean ratio of each demand to that at skew 0 under the same motion.

    The table has rows of analyses: bridge, skew_deg, choice, motion_id and peaks of whole motions.
    Returned are bridge, choice, skew_deg, demand, mean (geometric, in the unit of the demand),
    ratio with ratio_low and ratio_high (t interval of the logarithm at `LEVEL`) and n_motions.
    Motions whose demand is zero at either skew are left out.
    """
    rows: list[dict[str, Any]] = []
    for (bridge, choice), part in table.groupby(["bridge", "choice"], sort=False):
        for demand, skew in product(COMPARED, sorted({*part["skew_deg"]} - {0})):
            peaks = part.pivot_table(f"{WHOLE}{demand}", "motion_id", "skew_deg")
            both = peaks[(peaks[0] > 0.0) & (peaks[skew] > 0.0)]
            change = np.log((both[skew] / both[0]).to_numpy(dtype=np.float64))
            half = 0.0
            if change.size > 1:
                error = change.std(ddof=1) / sqrt(change.size)
                half = float(student.ppf(0.5 + LEVEL / 2, change.size - 1) * error)
            mean = float(change.mean()) if change.size else float("nan")
            row = {"bridge": bridge, "choice": choice, "skew_deg": skew, "demand": demand}
            interval = {"ratio_low": exp(mean - half), "ratio_high": exp(mean + half)}
            average = float(np.exp(np.log(both[skew]).mean()))
            row |= {"mean": average, "ratio": exp(mean), **interval, "n_motions": change.size}
            rows.append(row)
    return pd.DataFrame(rows)


def median_factors(table: pd.DataFrame) -> pd.DataFrame:
    """Return the factors of skew on median capacities, paired by motion, with their intervals.

    The table is that of `demand_ratios`; the column `demand` names component/state.
    """
    published = published_curves()
    states = list(capacities(published[published["era"] == 3], DEMANDS).values())
    whole = table.assign(**{name: table[f"{WHOLE}{name}"] for name in DEMANDS.values()})
    parts: list[pd.DataFrame] = []
    whole = whole.assign(beyond_model="", complete=whole["status"] == OK)
    for choice, part in whole.groupby("choice", sort=False):
        rows = prepared(part, list(DEMANDS.values()), SETTINGS).table
        found = median_effects(rows, states, SETTINGS, axes=["skew_deg"])
        parts.append(found[found["scope"] == "pooled"].assign(choice=choice))
    found = pd.concat(parts, ignore_index=True)
    found["skew_deg"] = found["to_value"]
    names = {"ci_low": "ratio_low", "ci_high": "ratio_high"}
    columns = ["bridge", "choice", "skew_deg", "demand", "ratio", *names.values(), "n_motions"]
    return found.rename(columns=names)[columns]


def _case(row: Mapping[str, Any]) -> str:
    choice = "" if row["choice"] == "none" else f", {row['choice']}"
    return f"{row['bridge']}, skew {row['skew_deg']:g}{choice}"


def _interval(row: Mapping[str, Any]) -> str:
    return f"{row['ratio']:.2f} ({row['ratio_low']:.2f} to {row['ratio_high']:.2f})"


def _figure(medians: pd.DataFrame) -> Figure:
    """Draw the factors on median capacities by bridge next to that of Hazus."""
    figure, axes = style.panels(1, len(BRIDGES), height_in=3.2, sharey=True)
    skews = np.linspace(0.0, SKEWS_DEG[-1], 61)
    colours = dict(
        zip(DEMANDS, (style.BLUE, style.ORANGE, style.GREEN, style.PINK, style.GREY), strict=False)
    )
    for axis, bridge in zip(axes[0], BRIDGES, strict=True):
        style.line(axis, skews, [hazus_factor(each) for each in skews], style.BLACK, "Hazus")
        rows = medians[(medians["bridge"] == bridge) & (medians["choice"] == "none")]
        for number, (demand, part) in enumerate(rows.groupby("demand", sort=False)):
            component = str(demand).split("/")[0]
            if not str(demand).endswith("/moderate") or component not in colours:
                continue
            x = part["skew_deg"] + 0.7 * (number % 5 - 2)
            ends = part["ratio"] - part["ratio_low"], part["ratio_high"] - part["ratio"]
            look = {"color": colours[component], "label": component.replace("_", " ")}
            axis.errorbar(x, part["ratio"], np.array(ends), fmt="o", ms=4, **look)
        style.label(axis, "skew (deg)", "median over that at skew 0", bridge)
    style.legend_above(figure, axes[0, 1])
    return figure

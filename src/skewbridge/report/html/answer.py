"""The first screen of the page: what the axes change, in words and as one forest plot."""

from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.tables.needed_motions import MORE
from skewbridge.fragility.tables.verdicts import (
    DETECTABLE,
    HIGHER,
    LOWER,
    NEGLIGIBLE,
    RATIO,
    UNDECIDED,
)
from skewbridge.report.axis_layout import value_text
from skewbridge.report.headline import DEMANDS
from skewbridge.report.verdict_style import (
    change_text,
    demand_name,
    interval_text,
    margin_text,
    verdict_style,
)
from skewbridge.variant.axes import axis

#: The plot: its width, where its axis lies, and how far it reaches at most, as a ratio.
_WIDTH, _LEFT, _RIGHT, _ROW, _TOP = 400.0, 126.0, 334.0, 24.0, 10.0
_REACH: Final = (0.4, 2.5)
_TICKS: Final = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0)
_TICK_ROOM: Final = 30.0
_ORDER: Final = (LOWER, HIGHER, DETECTABLE, UNDECIDED, NEGLIGIBLE)
#: Undecided because there is no number at all, not because its interval is wide.
_NO_ESTIMATE: Final = "no_estimate"


def model_name(bridge: object, abutment: object) -> str:
    """Return a bridge and its abutment model in words."""
    return f"{bridge}, {str(abutment).replace('_', '-')}"


def short_names(table: pd.DataFrame) -> dict[tuple[str, str], str]:
    """Return the names of the models of a table, each by what tells it from the others."""
    models = list(dict.fromkeys(zip(table["bridge"], table["abutment"], strict=True)))
    one_abutment, one_bridge = (len({model[part] for model in models}) == 1 for part in (1, 0))
    if one_abutment:
        return {model: model[0] for model in models}
    return {m: m[1].replace("_", "-") if one_bridge else model_name(*m) for m in models}


def plain_name(demand: str) -> str:
    """Return the label of a demand without its unit, for the middle of a sentence."""
    label = demand_name(demand)
    return label[:1].lower() + label[1:]


def widest(pooled: pd.DataFrame) -> pd.DataFrame:
    """Return the pooled effects on the headline demands from end to end of each axis."""
    table = pooled[pooled["demand"].isin(DEMANDS)]
    step = table["to_value"] - table["from_value"]
    keys = [table[name] for name in ("bridge", "abutment", "axis", "demand")]
    return table[step == step.groupby(keys).transform("max")]


def title_of(pooled: pd.DataFrame) -> str:
    """Return the answer of a study in one sentence, from its pooled effects."""
    table = widest(pooled)
    if table.empty:
        return "This study compares nothing: no two variants differ in one axis only"
    names = short_names(table)
    clauses: dict[str, list[str]] = {verdict: [] for verdict in _ORDER}
    for name, part in table.groupby("axis", sort=False):
        kind = next(each for each in _ORDER if (part["verdict"] == each).any())
        own = part[part["verdict"] == kind]
        if kind == NEGLIGIBLE:
            clauses[kind].append(axis(str(name)).title)
        else:
            clauses[kind].append(f"{axis(str(name)).title} {_claim(own, kind, names)}")
    said = [*clauses[LOWER], *clauses[HIGHER]]
    if clauses[DETECTABLE]:
        margin = margin_text(table.iloc[0])
        said.append(f"{_listed(clauses[DETECTABLE])} (whether by over {margin} is open)")
    said += clauses[UNDECIDED]
    if within := clauses[NEGLIGIBLE]:
        count = table["demand"].nunique()
        verb = "change" if len(within) > 1 else "changes"
        none = f"{verb} none of the {count} headline demands"
        said.append(f"{_listed(within)} {none} by more than {margin_text(table.iloc[0])}")
    text = "; ".join(said)
    return text[:1].upper() + text[1:]


def _claim(rows: pd.DataFrame, kind: str, models: dict[tuple[str, str], str]) -> str:
    """Return what is said of the rows of one axis that have the leading verdict."""
    if kind == UNDECIDED:
        names = _listed(dict.fromkeys(plain_name(each) for each in rows["demand"]))
        count = rows["n_motions"].max()
        return f"is not decided for {names} by {count:g} motion{'s' if count > 1 else ''}"
    size = rows["ratio"].map(np.log).abs()
    if size.isna().all():
        return f"changes {_listed(map(plain_name, rows['demand']))}"
    largest = rows.iloc[int(np.nanargmax(size.to_numpy()))]
    verb = "lowers" if largest["ratio"] < 1.0 else "raises"
    change = change_text(largest).lstrip("+-")
    model = models[largest["bridge"], largest["abutment"]]
    where = f" of {model}" if len(models) > 1 else ""
    return f"{verb} {plain_name(str(largest['demand']))}{where} by {change}"


def cards(pooled: pd.DataFrame, needed: pd.DataFrame) -> list[dict[str, Any]]:
    """Return a card per axis: its change, sentences for each model, and its part of the plot.

    Args:
        pooled: Pooled rows of the effects.
        needed: Table of `needed_motions`.
    """
    table = widest(pooled)
    keys = ["bridge", "abutment", "demand", "axis", "from_value", "to_value"]
    table = table.merge(needed[[*keys, "forecast", "needed_motions"]], on=keys, how="left")
    scale, names = _Scale(table), short_names(table)
    out: list[dict[str, Any]] = []
    for key, part in table.groupby(["axis", "from_value", "to_value"], sort=False):
        name, low, high = key
        told = axis(str(name))
        parts = part.groupby(["bridge", "abutment"], sort=False)
        models = [(names[str(model[0]), str(model[1])], rows) for model, rows in parts]
        out.append(
            {
                "title": f"{told.label} {value_text(told, float(str(low)))} to "
                f"{value_text(told, float(str(high)))}",
                "sentences": [
                    (model if len(models) > 1 else "", _sentence(rows)) for model, rows in models
                ],
                "plot": scale.plot(models),
            }
        )
    return out


def _sentence(rows: pd.DataFrame) -> str:
    """Return the effects of one axis on one model in words, grouped by verdict."""
    said: list[str] = []
    estimated = rows[["ratio", "difference"]].notna().any(axis=1)
    verdicts = rows["verdict"].where(estimated | (rows["verdict"] != UNDECIDED), _NO_ESTIMATE)
    for verdict, start in (
        (LOWER, "Lowers {}."),
        (HIGHER, "Raises {}."),
        (DETECTABLE, "Direction known, size against the margin not: {}."),
        (UNDECIDED, "More motions needed for {}."),
        (_NO_ESTIMATE, "No estimate for {}: too few motions are complete on both sides."),
        (NEGLIGIBLE, "No change by more than {margin}: {}."),
    ):
        own = rows[verdicts == verdict]
        if own.empty:
            continue
        detail = verdict in (LOWER, HIGHER, DETECTABLE, UNDECIDED)
        words = [_worded(row, detail) for row in own.to_dict("records")]
        said.append(start.format(_listed(words), margin=margin_text(own.iloc[0])))
    return " ".join(said)


def _worded(row: dict[Any, Any], detail: bool) -> str:
    name = plain_name(str(row["demand"]))
    if not detail:
        return name
    more = f"; about {row['needed_motions']:.0f} motions" if row["forecast"] == MORE else ""
    return f"{name} {change_text(row)} ({interval_text(row)}{more})"


def _listed(words: Iterable[str]) -> str:
    first, last = list(words)[:-1], list(words)[-1]
    return f"{', '.join(first)} and {last}" if first else last


class _Scale:
    """The common axis of the cards: ratios, logarithmic, as far as the intervals reach."""

    def __init__(self, table: pd.DataFrame) -> None:
        judged = table[table["judged_by"] == RATIO]
        self.margin = float(judged["margin"].iloc[0]) if len(judged) else 0.0
        ends = judged[["ci_low", "ratio", "ci_high"]].to_numpy(dtype=np.float64)
        ends = ends[np.isfinite(ends) & (ends > 0.0)]
        low = min([1.0 - 2.5 * self.margin, *ends]) / 1.01
        high = max([1.0 + 2.5 * self.margin, *ends]) * 1.01
        self.low, self.high = np.log(max(low, _REACH[0])), np.log(min(high, _REACH[1]))

    def x(self, ratio: float) -> float:
        place = (np.log(max(ratio, 1e-9)) - self.low) / (self.high - self.low)
        return round(float(_LEFT + (_RIGHT - _LEFT) * np.clip(place, 0.0, 1.0)), 1)

    def plot(self, models: list[tuple[str, pd.DataFrame]]) -> dict[str, Any]:
        """Return what the template draws of one axis."""
        rows = list(self._rows(models))
        bottom = _TOP + _ROW * len(rows)
        return {
            "width": _WIDTH,
            "height": bottom + _TICK_ROOM,
            "top": _TOP - 6.0,
            "bottom": bottom,
            "band": (self.x(1.0 - self.margin), self.x(1.0 + self.margin)),
            "zero": self.x(1.0),
            "ticks": self._ticks(),
            "rows": rows,
        }

    def _rows(self, models: list[tuple[str, pd.DataFrame]]) -> Iterator[dict[str, Any]]:
        place = 0
        for model, part in models:
            if len(models) > 1:
                yield {"y": _TOP + _ROW * (place + 0.5), "head": model}
                place += 1
            for row in part.to_dict("records"):
                style = verdict_style(row)
                drawn = row["judged_by"] == RATIO and np.isfinite(row["ratio"])
                ends = [row["ci_low"], row["ratio"], row["ci_high"]] if drawn else []
                yield {
                    "y": _TOP + _ROW * (place + 0.5),
                    "head": "",
                    "label": demand_name(str(row["demand"])),
                    "x": [self.x(float(end)) if np.isfinite(end) else None for end in ends],
                    "fill": style.fill,
                    "text": change_text(row),
                    "title": f"{style.sign} {change_text(row)}, {interval_text(row)}",
                }
                place += 1

    def _ticks(self) -> list[tuple[float, str]]:
        shown: list[tuple[float, str]] = [(self.x(1.0), "0")]
        for tick in sorted(_TICKS, key=lambda value: -abs(np.log(value))):
            x = self.x(tick)
            inside = self.low <= np.log(tick) <= self.high
            if inside and all(abs(x - other) > 44.0 for other, _ in shown):
                shown.append((x, f"{100 * (tick - 1):+.0f} %"))
        return sorted(shown)

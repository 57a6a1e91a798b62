"""Figures of effects: effects on demands by intensity, modelling choices compared with them."""

from textwrap import fill
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from skewbridge.demands.columns import demands_for
from skewbridge.files.tables import records_of
from skewbridge.fragility.verdicts import CELL, DECIDED
from skewbridge.report.appearance import (
    MAX_BANDS,
    STYLE,
    STYLES,
    VARIANT_COLOURS,
    demand_name,
    groups_of,
    plain_log_ticks,
    value_text,
)
from skewbridge.variant.axes import Axis, axes_of


def intensity_demands(intensities: pd.DataFrame) -> list[str]:
    """Return the headline demands that have effects by intensity."""
    return list(demands_for("headline", intensities["demand"]))


def effects_by_intensity(intensities: pd.DataFrame, im_label: str) -> Figure:
    """Draw the effect of each axis on the headline demands as a line with its band over intensity.

    Dots are at the reference intensity of the bridge; an open dot is at the end of the range of the
    pairs, where the reference intensity lies outside of it.
    """
    names, along = intensity_demands(intensities), axes_of(intensities["axis"])
    with mpl.rc_context(STYLE):
        size = 2.9 * len(along) + 0.9, 1.9 * len(names) + 0.9
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(names), len(along), squeeze=False, sharex=True, sharey="row")
        for row, name in zip(panels, names, strict=True):
            own = intensities[intensities["demand"] == name]
            for axes, axis in zip(row, along, strict=True):
                _intensity_panel(axes, own[own["axis"] == axis.name], axis)
            row[0].set_ylabel(fill(f"Ratio of {demand_name(name).lower()}", 24))
        for top, bottom, axis in zip(panels[0], panels[-1], along, strict=True):
            top.legend(fontsize=7, loc="best")
            top.set_title(axis.label, fontsize=9)
            bottom.set_xlabel(im_label)
        panels[0, 0].set_xscale("log")
        plain_log_ticks(panels[0, 0].xaxis)
        level = 100 * float(intensities["level"].iloc[0])
        title = f"Effect by intensity with {level:g} % band, same motions, all variants"
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def _intensity_panel(axes: Axes, rows: pd.DataFrame, changed: Axis) -> None:
    axes.axhline(1.0, color="#777777", linewidth=0.8)
    changes = groups_of(rows, ["from_value", "to_value"])
    for i, (ends, own) in enumerate(changes):
        line, colour = own.sort_values("im"), VARIANT_COLOURS[i % len(VARIANT_COLOURS)]
        if len(changes) - i <= MAX_BANDS:  # the largest changes
            band = line["im"], line["ci_low"], line["ci_high"]
            axes.fill_between(*band, color=colour, alpha=0.18, lw=0)
        label = " to ".join(value_text(changed, value) for value in ends)
        dash = ("-", "--", ":", "-.")[i % 4]
        axes.plot(line["im"], line["ratio"], dash, color=colour, label=label)
        for item in records_of(own[own["at_reference"]]):
            inside = "white" if item["clipped"] else colour
            axes.plot(item["im"], item["ratio"], "o", ms=5, color=colour, mfc=inside)


def widths_by_analyses(rounds: pd.DataFrame) -> Figure:
    """Draw the half-width of the interval of each headline effect over the analyses of the study.

    A dot is at the round of the verdict; lines without one are open. The columns of the table are
    `fragility.verdicts.ROUND_COLUMNS`.
    """
    rounds = rounds.assign(width=50.0 * np.log(rounds["ci_high"] / rounds["ci_low"]))
    kinds = {"demand": "Demands", "median_capacity": "Median capacities"}
    styles = {style.verdict: style for style in STYLES.values() if style.verdict in DECIDED}
    dot: dict[str, Any] = {
        "marker": "o",
        "linestyle": "",
        "markersize": 5,
        "markeredgecolor": "#39434a",
    }
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.8, 3.0), layout="constrained")
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, (kind, title) in zip(panels, kinds.items(), strict=True):
            for _, own in rounds[rounds["quantity"] == kind].groupby(list(CELL), sort=False):
                line = own.sort_values("round")
                axes.plot(line["analyses"], line["width"], color="#b9c0c5", linewidth=0.8)
                for first in records_of(line[line["verdict"].isin(DECIDED)].head(1)):
                    fill_colour = styles[first["verdict"]].fill
                    axes.plot(first["analyses"], first["width"], color=fill_colour, **dot)
            axes.set_title(title, fontsize=9)
            axes.set_xlabel("Analyses of the study")
        panels[0].set_yscale("log")
        panels[0].set_ylabel("Half-width of the interval (%)")
        plain_log_ticks(panels[0].yaxis)
        handles = [
            Line2D([], [], color=style.fill, label=style.text, **dot) for style in styles.values()
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    return figure


_COLOURS: Final = {"choice": VARIANT_COLOURS[0], "axis": VARIANT_COLOURS[1]}
_KINDS: Final = {"choice": "choice of the modeller", "axis": "axis of the study"}
LINEAR_PCT: Final = 5.0  # the scale is linear up to here, then logarithmic
_TICKS_PCT: Final = (2, 5, 20, 100, 500)
_LEAST_PCT: Final = 6.0  # range of a panel without any change


def _ranked(choices: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the rows of each headline demand, smallest change first, by the demand's label.

    Added are ``bar``, the name of the choice or axis with its change, ``percent``, its ``text``
    and its ``size``, -1 without a pair.
    """
    # imported here: it loads the solver, and few studies compare choices
    from skewbridge.study.modelling_choices import CHOICES

    labels = {choice.key: choice.label for choice in CHOICES}
    labels |= {each.name: each.label for each in axes_of(choices["name"])}
    percent = 100.0 * (choices["ratio"] - 1.0)
    change = choices["from_value"] + " → " + choices["to_value"]
    texts = percent.map("{:+.1f} %".format).replace({"-0.0 %": "0.0 %", "+0.0 %": "0.0 %"})
    some = ", " + choices["n"].astype(str) + " of " + choices["n_pairs"].astype(str)
    texts = (texts + some.where(choices["n"] < choices["n_pairs"], "")).where(
        choices["n"] > 0, "no pair"
    )
    rows = choices.assign(
        bar=choices["name"].map(labels) + " " + change,
        change=change,
        percent=percent,
        text=texts,
        size=choices["ratio"].map(np.log).abs().where(choices["n"] > 0, -1.0),
    ).sort_values("size", kind="stable")
    demands = demands_for("headline", choices["demand"].unique())
    return {demand_name(demand): rows[rows["demand"] == demand] for demand in demands}


def tornado(choices: pd.DataFrame) -> Figure:
    """Draw for every headline demand how far each choice and each axis moves it, by size.

    The table is that of one bridge with one abutment model.
    """
    ranked = _ranked(choices)
    bars, rows = max(map(len, ranked.values())), -(-len(ranked) // 2)
    with mpl.rc_context(STYLE):
        size = 12.5, rows * (0.21 * bars + 0.95) + 0.4
        figure = Figure(figsize=size, layout="constrained")
        panels = list(figure.subplots(rows, 2, squeeze=False).flat)
        for panel, (label, own) in zip(panels, ranked.items(), strict=False):
            _tornado_panel(panel, own)
            panel.set_title(label, loc="left", fontsize=10, fontweight="bold")
        for panel in panels[len(ranked) :]:
            panel.axis("off")
        handles = [Patch(color=_COLOURS[kind], label=text) for kind, text in _KINDS.items()]
        figure.legend(handles=handles, loc="outside upper right", ncols=2)
    return figure


def _tornado_panel(panel: Axes, rows: pd.DataFrame) -> None:
    rows = rows.assign(place=np.arange(len(rows)))
    known = rows[rows["n"] > 0]
    reach = max([_LEAST_PCT, *(1.3 * known["percent"].abs())])
    panel.barh(known["place"], known["percent"], height=0.72, color=known["kind"].map(_COLOURS))
    ends = (100.0 * (known[["lowest", "highest"]] - 1.0)).clip(-reach, reach)
    panel.hlines(known["place"], ends["lowest"], ends["highest"], color="#333333", linewidth=0.8)
    for place, text in zip(rows["place"], rows["text"], strict=True):
        across = panel.get_yaxis_transform()
        panel.text(1.01, place, text, transform=across, va="center", fontsize=7.5)
    panel.set_yticks(rows["place"], rows["bar"], fontsize=8)
    panel.set_ylim(-0.6, len(rows) - 0.4)
    panel.axvline(0.0, color="black", linewidth=0.8)
    panel.set_xscale("symlog", linthresh=LINEAR_PCT)
    panel.set_xlim(-reach, reach)
    ticks = [tick for tick in _TICKS_PCT if tick <= reach]
    places = [*(-tick for tick in reversed(ticks)), 0, *ticks]
    panel.set_xticks(places, [f"{tick:+d}" if tick else "0" for tick in places], fontsize=8)
    panel.xaxis.set_minor_locator(NullLocator())
    panel.set_xlabel("change of the demand (%)")
    panel.grid(visible=False, axis="y")


def choice_findings(choices: pd.DataFrame) -> list[str]:
    """Return a sentence per headline demand: which choices move it more than friction does."""
    found: list[str] = []
    for label, rows in _ranked(choices).items():
        of_friction = rows[(rows["name"] == "friction") & (rows["n"] > 0)].sort_index()
        for friction in records_of(of_friction.head(1)):
            larger = rows[(rows["kind"] == "choice") & (rows["size"] > friction["size"])]
            largest = records_of(larger.iloc[::-1].drop_duplicates("name"))
            sizes = ", ".join(f"{row['bar']} ({row['text']})" for row in largest)
            found.append(
                f"{label}: friction {friction['change']} moves it by {friction['text']}; "
                + (f"more than that do {sizes}." if sizes else "no choice tried moves it more.")
            )
    return found

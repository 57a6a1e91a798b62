"""The answer of the default study in the README: sentences, a table and a picture.

`make headline` writes them from a finished study, with the tables behind them in `docs/data`; a
test compares the README with these tables.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, records_of
from skewbridge.files.text import write_text
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.fragility.verdicts import MEDIAN_CAPACITY, OK
from skewbridge.report.answer import (
    NOT_REACHED,
    answer_table,
    axis_sentences,
    change_name,
    effect_name,
    failure_sentences,
    headline_rows,
    motions_sentence,
    ratio_interval,
    run_counts,
    short_names,
    with_seats,
)
from skewbridge.report.axis_layout import STYLE
from skewbridge.report.verdict_style import signed
from skewbridge.study.folder import StudyFolder

ROOT: Final = Path(__file__).parents[1]
#: Tables behind the headline: effects, counts of runs, and motions.
EFFECTS: Final = Path("docs/data/headline.csv")
RUNS: Final = Path("docs/data/headline_runs.csv")
MOTIONS: Final = Path("docs/data/headline_motions.csv")
PICTURE: Final = Path("docs/images/readme.png")
BEGIN: Final = "<!-- headline: written by make headline -->"
END: Final = "<!-- end of the headline -->"
_MOTION_COLUMNS: Final = ("motion_id", "source", "magnitude", "distance_km")
_COLOURS: Final = ("#1f5a96", "#c8501e", "#3d8b5f", "#7b4b94", "#8a6d1d")
_POINTS: Final = 61


def headline_text(table: pd.DataFrame, runs: pd.DataFrame, motions: pd.DataFrame) -> str:
    """Return the headline as Markdown: a sentence per axis, failures, and a table of medians.

    Args:
        table: Table of `answer_table`.
        runs: Table of `run_counts`.
        motions: Table of the suite.
    """
    lines = [f"- **{change}.** {sentence}" for change, sentence in axis_sentences(table)]
    medians = table[table["quantity"] == MEDIAN_CAPACITY]
    states = [state for state in HEADLINE_STATES if (medians["demand"] == state).any()]
    level = 100.0 * medians["level"].dropna().iloc[0]
    names = short_names(table)
    lines += [
        f"- {' '.join(failure_sentences(runs))}",
        f"- {motions_sentence(motions, table)}",
        "",
        f"Brackets: {level:g} % intervals, averages over all other axes.",
        "",
        f"Change of the median capacity, averaged over all other axes, with its {level:g} % "
        "interval and the verdict that holds for all comparisons together:",
        "",
        f"| bridge | change | {' | '.join(effect_name(state) for state in states)} |",
        f"|---|---|{'---|' * len(states)}",
    ]
    keys = ["bridge", "abutment", "axis", "from_value", "to_value"]
    for key, part in medians.groupby(keys, sort=False):
        cells = {row["demand"]: _cell(row) for row in records_of(part)}
        model, place = (
            (str(key[0]), str(key[1])),
            (str(key[2]), float(str(key[3])), float(str(key[4]))),
        )
        shown = " | ".join(cells.get(state, "") for state in states)
        lines.append(f"| {names[model]} | {change_name(*place)} | {shown} |")
    return "\n".join(lines)


def _cell(row: dict[str, Any]) -> str:
    if row["status"] != OK:
        return "not reached" if row["status"] == NOT_REACHED else "not estimable"
    change = signed(100.0 * (row["ratio"] - 1.0), " %")
    return f"{change} ({ratio_interval(row)}), {row['claim']}"


def headline_figure(table: pd.DataFrame, joint: pd.DataFrame) -> Figure:
    """Draw the effects on median capacities, and medians over the skew from the joint model."""
    medians = headline_rows(table[table["quantity"] == MEDIAN_CAPACITY])
    models = list(dict.fromkeys(zip(medians["bridge"], medians["abutment"], strict=True)))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.0, 3.6 * len(models)), layout="constrained")
        for row, pair in enumerate(figure.subplots(len(models), 2, squeeze=False)):
            bridge, abutment = models[row]
            own = (medians["bridge"] == bridge) & (medians["abutment"] == abutment)
            _draw_effects(pair[0], medians[own])
            same = (joint["bridge"] == bridge) & (joint["abutment"] == abutment)
            _draw_medians(pair[1], joint[same], list(dict.fromkeys(medians[own]["demand"])))
            pair[0].set_title(f"{bridge}: change of median capacity", loc="left", fontsize=10)
            pair[1].set_title("median capacity over skew, joint model", loc="left", fontsize=10)
    return figure


def _draw_effects(axes: Axes, table: pd.DataFrame) -> None:
    changes = [
        change_name(str(name), float(low), float(high))
        for name, low, high in zip(
            table["axis"], table["from_value"], table["to_value"], strict=True
        )
    ]
    rows = list(dict.fromkeys(changes))
    states = list(dict.fromkeys(table["demand"]))
    for column, state in enumerate(states):
        part = table[table["demand"] == state]
        y = np.array([rows.index(changes[at]) for at in np.flatnonzero(table["demand"] == state)])
        middle, low, high = (
            100.0 * (part[name].to_numpy() - 1.0) for name in ("ratio", "ci_low", "ci_high")
        )
        axes.errorbar(
            middle,
            y + 0.14 * (column - 0.5 * (len(states) - 1)),
            xerr=np.stack([middle - low, high - middle]),
            fmt="o",
            markersize=4,
            color=_COLOURS[column],
            label=effect_name(str(state)),
        )
    margin = 100.0 * float(table["margin"].iloc[0])
    axes.axvspan(-margin, margin, color="#cfe3f5", alpha=0.6, zorder=0, label=f"±{margin:g} %")
    axes.axvline(0.0, color="#444444", linewidth=0.8)
    axes.set_yticks(range(len(rows)), rows)
    axes.invert_yaxis()
    axes.set_xlabel("change (%)")
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def _draw_medians(axes: Axes, joint: pd.DataFrame, states: Sequence[str]) -> None:
    keys = joint["component"] + "/" + joint["limit_state"]
    for number, state in enumerate(states):
        own = joint[(joint["status"] == FITTED) & (keys == state)]
        if own.empty:
            continue
        model = JointModel.of_row(records_of(own)[0])
        limits = model.axis_range.limits
        if "skew_deg" not in limits:
            continue
        skew = np.linspace(*limits["skew_deg"], _POINTS)
        middle = model.axis_range.middle
        curve = np.array([model.median(middle | {"skew_deg": value}) for value in skew])
        axes.plot(skew, curve[:, 0], color=_COLOURS[number], label=effect_name(state))
        axes.fill_between(skew, curve[:, 1], curve[:, 2], color=_COLOURS[number], alpha=0.15, lw=0)
    axes.set_xlabel("skew (deg)")
    axes.set_ylabel("median intensity (g)")
    axes.set_ylim(bottom=0.0)
    if axes.lines:
        axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def with_headline(readme: str, text: str) -> str:
    """Return the README with the headline between its markers.

    Raises:
        InputError: It has no such markers.
    """
    if BEGIN not in readme or END not in readme:
        raise InputError(f"README.md lacks the markers {BEGIN} and {END}")
    before, rest = readme.split(BEGIN, 1)
    return f"{before}{BEGIN}\n{text}\n{END}{rest.split(END, 1)[1]}"


def stored_tables(root: Path = ROOT) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Return the stored tables behind the headline: effects, counts of runs, motions."""
    paths = (root / path for path in (EFFECTS, RUNS, MOTIONS))
    effects, runs, motions = (pd.read_csv(path) for path in paths)
    return effects, runs.assign(axis=runs["axis"].fillna("")), motions


def write_headline(results: Path, root: Path = ROOT) -> None:
    """Write the tables, the README's headline and its picture from a finished study.

    Raises:
        InputError: The study compares no variants.
    """
    folder = StudyFolder(results)
    demands = read_frame(folder.demands)
    names = ("median_effects", "effects", "intensity_effects", "curves")
    medians, effects, intensities, curves = (read_frame(folder.fragility(name)) for name in names)
    table = answer_table(medians=medians, effects=effects, intensities=intensities, curves=curves)
    if not (table["quantity"] == MEDIAN_CAPACITY).any():
        raise InputError("the study has no pooled effect on a median capacity of the headline")
    suite = read_frame(folder.suite)
    suite = suite[[name for name in _MOTION_COLUMNS if name in suite]]
    tables = {EFFECTS: with_seats(table, demands), RUNS: run_counts(demands), MOTIONS: suite}
    for path, frame in tables.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        write_text(root / path, frame.to_csv(index=False, float_format="%.6g"))
    readme = (root / "README.md").read_text(encoding="utf-8")
    stored = stored_tables(root)
    write_text(root / "README.md", with_headline(readme, headline_text(*stored)))
    headline_figure(stored[0], read_frame(folder.fragility("joint"))).savefig(
        root / PICTURE, dpi=110
    )


if __name__ == "__main__":
    write_headline(Path(sys.argv[1] if len(sys.argv) > 1 else "results"))

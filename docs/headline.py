"""Headline results of the default study in the README: sentences and a figure.

`make headline` writes them from a finished study and stores the tables behind them in `docs/data`;
a test compares the README with these tables.
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
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.fragility.verdicts import MEDIAN_CAPACITY, OK
from skewbridge.report.answer import (
    CERTAINTY,
    LEADING_STATES,
    answer_table,
    change_name,
    effect_name,
    extent_of_data,
    failure_sentences,
    motions_sentence,
    no_ratio_text,
    run_counts,
    short_names,
    untested_skew_sentence,
)
from skewbridge.report.appearance import (
    STYLE,
    VARIANT_COLOURS,
    change_text,
    interval_text,
)
from skewbridge.study.folder import StudyFolder

ROOT: Final = Path(__file__).parents[1]
#: Tables behind the headline: effects, counts of runs and motions.
EFFECTS: Final = Path("docs/data/headline.csv")
RUNS: Final = Path("docs/data/headline_runs.csv")
MOTIONS: Final = Path("docs/data/headline_motions.csv")
PICTURE: Final = Path("docs/images/readme.png")
BEGIN: Final = "<!-- headline: written by make headline -->"
END: Final = "<!-- end of the headline -->"
_MOTION_COLUMNS: Final = ("motion_id", "source", "event", "magnitude", "distance_km")


def headline_text(table: pd.DataFrame, runs: pd.DataFrame, motions: pd.DataFrame) -> str:
    """Return the headline as Markdown: one sentence per axis, then failures and motions.

    Args:
        table: Table of `answer_table`.
        runs: Table of `run_counts`.
        motions: Table of the suite.
    """
    medians = table[table["quantity"] == MEDIAN_CAPACITY]
    names = short_names(table)
    lines: list[str] = []
    for key, part in medians.groupby(["axis", "from_value", "to_value"], sort=False):
        clauses = [
            f"for {effect_name(state)} by "
            + " and ".join(
                f"{_change(row)} in {names[row['bridge'], row['abutment']]}"
                for row in records_of(part[part["demand"] == state])
            )
            for state in LEADING_STATES
            if (part["demand"] == state).any()
        ]
        change = change_name(str(key[0]), float(str(key[1])), float(str(key[2])))
        lines.append(f"- **{change}** changes the median capacity {', and '.join(clauses)}.")
    level = 100.0 * medians["level"].dropna().iloc[0]
    failures, bounds = failure_sentences(runs)
    skews_deg = runs.loc[runs["axis"] == "skew_deg", "value"]
    return "\n".join(
        [
            *lines,
            f"- {failures} {bounds}",
            "",
            f"Values are averages over all other axes; {level:g} % intervals are in brackets. "
            f"{motions_sentence(motions, table)} {untested_skew_sentence(skews_deg)}".rstrip(),
        ]
    )


def _change(row: dict[str, Any]) -> str:
    if row["status"] != OK:
        return f"an unknown amount ({no_ratio_text(row)})"
    details = interval_text(row), CERTAINTY[row["claim"]], extent_of_data(row)
    return f"{change_text(row)} ({', '.join(filter(None, details))})"


def headline_figure(table: pd.DataFrame) -> Figure:
    """Draw the effects on median capacities, one panel per bridge and abutment model."""
    medians = table[(table["quantity"] == MEDIAN_CAPACITY) & (table["status"] == OK)]
    names, level = short_names(medians), 100.0 * float(medians["level"].iloc[0])
    states = [state for state in HEADLINE_STATES if (medians["demand"] == state).any()]
    groups = list(medians.groupby(["bridge", "abutment"], sort=False))
    with mpl.rc_context(STYLE):
        size = (5.0 * len(groups) + 1.0, 0.22 * len(states) * 3 + 1.2)
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(1, len(groups), squeeze=False, sharex=True, sharey=True)[0]
        for axes, (model, part) in zip(panels, groups, strict=True):
            _draw_effects(axes, part, states)
            axes.set_title(names[str(model[0]), str(model[1])], loc="left", fontsize=10)
        panels[0].invert_yaxis()
        handles, labels = panels[-1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=9)
        title = f"Change of the median capacity with its {level:g} % interval"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    return figure


def _draw_effects(axes: Axes, table: pd.DataFrame, states: Sequence[str]) -> None:
    """Draw the effects with intervals, one row per change of an axis, states offset in height."""
    keys = ["axis", "from_value", "to_value"]
    changes = [tuple(row) for row in table[keys].drop_duplicates().itertuples(index=False)]
    margin = 100.0 * float(table["margin"].iloc[0])
    axes.axvspan(-margin, margin, color="#e9edf0", zorder=0, label=f"within ±{margin:g} %")
    axes.axvline(0.0, color="#444444", linewidth=0.8)
    for number, state in enumerate(states):
        rows = table[table["demand"] == state]
        at = [changes.index(tuple(row)) for row in rows[keys].itertuples(index=False)]
        middle, low, high = (
            100.0 * (rows[name].to_numpy() - 1.0) for name in ("ratio", "ci_low", "ci_high")
        )
        axes.errorbar(
            middle,
            np.array(at) + 0.16 * (number - 0.5 * (len(states) - 1)),
            xerr=np.stack([middle - low, high - middle]),
            fmt="o",
            markersize=4,
            color=VARIANT_COLOURS[number],
            label=effect_name(str(state)),
        )
    axes.set_yticks(range(len(changes)), [change_name(*change) for change in changes])
    axes.set_xlabel("change (%)")


def with_headline(readme: str, text: str) -> str:
    """Return the README with a new headline between its markers.

    Raises:
        InputError: The README lacks a marker.
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
    """Write the tables, the README headline and its figure from a finished study.

    Raises:
        InputError: The study has no pooled effect on a median capacity of the headline.
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
    tables = {EFFECTS: table, RUNS: run_counts(demands), MOTIONS: suite}
    for path, frame in tables.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        write_text(root / path, frame.to_csv(index=False, float_format="%.9g"))
    readme = (root / "README.md").read_text(encoding="utf-8")
    stored = stored_tables(root)
    write_text(root / "README.md", with_headline(readme, headline_text(*stored)))
    headline_figure(stored[0]).savefig(root / PICTURE, dpi=110)


if __name__ == "__main__":
    write_headline(Path(sys.argv[1] if len(sys.argv) > 1 else "results"))

"""The answer of the default study in the README: a table, its picture, and the file behind them.

`make headline` runs this module on a finished study; a test compares the README with the file.
"""

import sys
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from skewbridge.demands.columns import label_of
from skewbridge.errors import InputError
from skewbridge.fragility.old_joint.model import JointModel
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.fragility_style import STYLE
from skewbridge.study.folder import StudyFolder
from skewbridge.variant.axes import axes_of, axis

ROOT: Final = Path(__file__).parents[3]
DATA: Final = Path("docs/data/headline.csv")
PICTURE: Final = Path("docs/images/readme.png")
BEGIN: Final = "<!-- headline: written by make headline -->"
END: Final = "<!-- end of the headline -->"
DEMANDS: Final = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
#: States whose medians over the skew are drawn where they have a joint model.
STATES: Final = (("column_drift", "slight"), ("unseating", "slight"), ("unseating", "moderate"))
COLUMNS: Final = (
    "bridge", "abutment", "axis", "from_value", "to_value", "demand", "ratio", "ci_low", "ci_high",
    "level", "n_motions",
)  # fmt: skip
_COLOURS: Final = ("#1f5a96", "#c8501e", "#3d8b5f", "#7b4b94")
_POINTS: Final = 61


def headline_table(effects: pd.DataFrame) -> pd.DataFrame:
    """Return the pooled effects of the headline: each axis from its smallest to its largest value.

    Raises:
        InputError: The table has no such effect.
    """
    pooled = effects[(effects["scope"] == "pooled") & (effects["quantity"] == "demand")]
    pooled = pooled[pooled["demand"].isin(DEMANDS) & pooled["ratio"].notna()]
    widest = pooled.groupby(["bridge", "abutment", "axis"])["to_value"].transform("max")
    table = pooled[pooled["to_value"] == widest]
    if table.empty:
        raise InputError("the study has no pooled effect of the demands of the headline")
    order = {each.name: place for place, each in enumerate(axes_of(set(table["axis"])))}
    place = {name: number for number, name in enumerate(DEMANDS)}
    table = table.assign(_axis=table["axis"].map(order), _demand=table["demand"].map(place))
    table = table.sort_values(["bridge", "abutment", "_axis", "_demand"])
    return table[list(COLUMNS)].reset_index(drop=True)


def headline_text(table: pd.DataFrame) -> str:
    """Return the headline as Markdown: a table of changes in per cent with their intervals."""
    first = table.iloc[0]
    names = [name for name in DEMANDS if name in set(table["demand"])]
    heads = [label_of(name).split(" (")[0] for name in names]
    lines = [
        "Change of demand in per cent, averaged over all other axes, with its "
        f"{100.0 * first['level']:.0f} % interval",
        f"({_counts(table['n_motions'])} synthetic motions, the same for every variant):",
        "",
        f"| bridge | from, to | {' | '.join(heads)} |",
        f"| --- | --- |{' --- |' * len(names)}",
    ]
    keys = ["bridge", "abutment", "axis", "from_value", "to_value"]
    for key, part in table.groupby(keys, sort=False):
        bridge, _, name, low, high = key
        changes = {str(row["demand"]): _change(row) for row in part.to_dict("records")}
        shown = [changes.get(each, "") for each in names]
        step = _step(str(name), float(str(low)), float(str(high)))
        lines.append(f"| {bridge} | {step} | {' | '.join(shown)} |")
    return "\n".join(lines)


def _counts(motions: pd.Series) -> str:
    """Return how many motions the effects have: those in which a pair tells a change."""
    fewest, most = int(motions.min()), int(motions.max())
    return str(most) if fewest == most else f"{fewest} to {most}"


def _step(name: str, low: float, high: float) -> str:
    told = axis(name)
    unit = "" if told.unit == "-" else f" {told.unit}"
    return f"{told.label.lower()} {low:g} to {high:g}{unit}"


def _change(row: Mapping[Hashable, Any]) -> str:
    middle, low, high = (
        100.0 * (float(row[each]) - 1.0) for each in ("ratio", "ci_low", "ci_high")
    )
    return f"{middle:+.1f} ({low:+.1f} to {high:+.1f})"


def headline_figure(table: pd.DataFrame, joint: pd.DataFrame) -> Figure:
    """Draw the effects with their intervals, and medians over the skew from the joint model."""
    models = list(dict.fromkeys(zip(table["bridge"], table["abutment"], strict=True)))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.0, 3.3 * len(models)), layout="constrained")
        for row, key in enumerate(figure.subplots(len(models), 2, squeeze=False)):
            own = (table["bridge"] == models[row][0]) & (table["abutment"] == models[row][1])
            _effects(key[0], table[own])
            same = (joint["bridge"] == models[row][0]) & (joint["abutment"] == models[row][1])
            _medians(key[1], joint[same])
            key[0].set_title(f"{models[row][0]}: change of demand", loc="left", fontsize=10)
            key[1].set_title("median capacity over skew, joint model", loc="left", fontsize=10)
    return figure


def _effects(axes: Axes, table: pd.DataFrame) -> None:
    steps = list(
        dict.fromkeys(zip(table["axis"], table["from_value"], table["to_value"], strict=True))
    )
    names = [name for name in DEMANDS if name in set(table["demand"])]
    for column, name in enumerate(names):
        part = table[table["demand"] == name]
        at = [
            steps.index(key)
            for key in zip(part["axis"], part["from_value"], part["to_value"], strict=True)
        ]
        y = np.array(at) + 0.16 * (column - 0.5 * (len(names) - 1))
        middle, low, high = (
            100.0 * (part[each].to_numpy() - 1.0) for each in ("ratio", "ci_low", "ci_high")
        )
        axes.errorbar(
            middle,
            y,
            xerr=np.stack([middle - low, high - middle]),
            fmt="o",
            markersize=4,
            color=_COLOURS[column],
            label=label_of(name).split(" (")[0],
        )
    axes.axvspan(-5.0, 5.0, color="#cfe3f5", alpha=0.6, zorder=0, label="within ±5 %")
    axes.axvline(0.0, color="#444444", linewidth=0.8)
    axes.set_yticks(range(len(steps)), [_step(*step) for step in steps])
    axes.invert_yaxis()
    axes.set_xlabel("change (%)")
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def _medians(axes: Axes, joint: pd.DataFrame) -> None:
    drawn = joint[joint["preferred"].to_numpy(dtype=bool) & (joint["status"] == FITTED)]
    for number, (component, state) in enumerate(STATES):
        own = drawn[(drawn["component"] == component) & (drawn["limit_state"] == state)]
        if own.empty:
            continue
        model = JointModel.of_row({str(key): value for key, value in own.iloc[0].items()})
        if "skew_deg" not in model.box.limits:
            continue
        skew = np.linspace(*model.box.limits["skew_deg"], _POINTS)
        for friction, line in _frictions(model):
            place = {name: 0.5 * (low + high) for name, (low, high) in model.box.limits.items()}
            place |= {} if friction is None else {"friction": friction}
            found = np.array([model.median(place | {"skew_deg": value}) for value in skew])
            label = f"{component.replace('_', ' ')}, {state}"
            label += "" if friction is None else f", μ {friction:g}"
            axes.plot(skew, found[:, 0], line, color=_COLOURS[number], label=label)
            if line == "-":
                axes.fill_between(
                    skew, found[:, 1], found[:, 2], color=_COLOURS[number], alpha=0.15, lw=0
                )
    axes.set_xlabel("skew (deg)")
    axes.set_ylabel("median intensity (g)")
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def _frictions(model: JointModel) -> list[tuple[float | None, str]]:
    if "friction" not in model.box.limits:
        return [(None, "-")]
    low, high = model.box.limits["friction"]
    return [(low, "--"), (high, "-")]


def with_headline(readme: str, text: str) -> str:
    """Return the README with the headline between its marks.

    Raises:
        InputError: It has no such marks.
    """
    if BEGIN not in readme or END not in readme:
        raise InputError(f"README.md lacks the marks {BEGIN} and {END}")
    before, rest = readme.split(BEGIN, 1)
    return f"{before}{BEGIN}\n{text}\n{END}{rest.split(END, 1)[1]}"


def write_headline(results: Path, root: Path = ROOT) -> None:
    """Write the file, the README's headline and its picture from the tables of a study."""
    folder = StudyFolder(results)
    table = headline_table(read_frame(folder.fragility("effects")))
    (root / DATA).parent.mkdir(parents=True, exist_ok=True)
    write_text(root / DATA, table.to_csv(index=False, float_format="%.5f"))
    stored: Any = pd.read_csv(root / DATA)
    readme = (root / "README.md").read_text(encoding="utf-8")
    write_text(root / "README.md", with_headline(readme, headline_text(stored)))
    figure = headline_figure(stored, read_frame(folder.fragility("joint")))
    figure.savefig(root / PICTURE, dpi=110)


if __name__ == "__main__":
    write_headline(Path(sys.argv[1] if len(sys.argv) > 1 else "results"))

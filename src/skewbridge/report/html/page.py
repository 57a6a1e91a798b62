"""The report: tables and figures of a study joined in one self-contained HTML file."""

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined
from joblib import Parallel, delayed
from PIL import Image

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.demands.columns import demands_for
from skewbridge.demands.demand_columns import SHEAR_MODELS
from skewbridge.demands.suspect import SUSPECT
from skewbridge.files.tables import read_frame, read_stamp, records_of
from skewbridge.files.text import write_text
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.fragility.paper_table import (
    JOINT,
    paper_table,
    printed_rows,
    ratio_names,
    with_interval,
)
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import shear_model_medians
from skewbridge.fragility.verdicts import (
    MEDIAN_CAPACITY,
    MORE,
    OK,
    RATIO,
)
from skewbridge.report import answer
from skewbridge.report.answer import change_name, effect_name, listed, model_name
from skewbridge.report.axis_layout import (
    AXIS_COLOURS,
    in_words,
    named_value,
    plain_label,
    shown_axes,
    shown_in,
    shown_unit,
    threshold_text,
    value_text,
)
from skewbridge.report.effect_figures import choice_findings, choices_left_out
from skewbridge.report.html.explorer import explorer_data, library
from skewbridge.report.html.sketch import bridge_words, sketch
from skewbridge.report.methods import STATE_HEADS, methods_of
from skewbridge.report.study_figures import SECTIONS, Caption, read_captions
from skewbridge.report.verdict_style import (
    LEGEND,
    STYLES,
    change_text,
    demand_name,
    interval_text,
    margin_text,
    verdict_style,
)
from skewbridge.statuses import STATUSES
from skewbridge.study.config import StudyConfig, parse_config
from skewbridge.units import split_unit
from skewbridge.variant.axes import axes_of

_WIDEST_BAR: Final = 2.5  # largest ratio at the end of the bars of the answer


def write_report(
    *,
    tables: Mapping[str, Path],
    figures: Path,
    config: Mapping[str, Any],
    output: Path,
    choices: Path | None = None,
) -> None:
    """Write the report.

    Args:
        tables: Paths by name: demands, curves, medians, system, measures, joint, effects,
            intensity_effects, needed_motions, input_notes, contact_checks, sensitivity, suite,
            checks, captions; check_predict if it was made.
        figures: Folder of the figures.
        config: The configuration as plain values.
        output: The HTML file.
        choices: Table of modelling choices, where there is one.
    """
    frames = {name: read_frame(path) for name, path in tables.items() if path.suffix == ".parquet"}
    if choices is not None:
        frames["choices"] = read_frame(choices)
    study = parse_config(config)
    environment = Environment(
        loader=PackageLoader("skewbridge.report.html"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters |= {"number": _number, "unbroken": _unbroken}
    with shown_in(study.figures.units):
        parts = (
            _first_screen(frames, study),
            _effect_parts(frames),
            _table_parts(frames, study),
            _quality_parts(frames, json.loads(tables["checks"].read_text("utf-8")), study),
            {
                "gallery": pictures_of(read_captions(tables["captions"]), figures),
                "explorer": _explorer(frames, study.figures.units),
                "methods": methods_of(study, frames["suite"]),
                "state_heads": STATE_HEADS,
                "choices": _choices(frames["choices"]) if "choices" in frames else [],
                "config": yaml.safe_dump(dict(config), sort_keys=False),
                "provenance": dict(sorted(read_stamp(tables["demands"]).items())),
            },
        )
        texts = {name: value for part in parts for name, value in part.items()}
        page = environment.get_template("report.html.j2").render(**texts)
    write_text(output, page)


def _first_screen(frames: Mapping[str, pd.DataFrame], study: StudyConfig) -> dict[str, Any]:
    """Return the texts of the first screen: sketch, answer, failures, motions."""
    demands, curves = frames["demands"], frames["curves"]
    table = answer.answer_table(
        medians=frames["medians"],
        effects=frames["effects"],
        intensities=frames["intensity_effects"],
        curves=curves,
    )
    table, counts = answer.with_seats(table, demands), answer.run_counts(demands)
    bridges = [load_bridge(name) for name in dict.fromkeys(study.grid.bridge)]
    on_suites, suites_text = answer.suites_summary(frames["suites"], table)
    axes = {axis.name: sorted(demands[axis.name].unique()) for axis in axes_of(demands.columns)}
    drawn = sketch(bridges[0], axes["skew_deg"], axes["gap_mm"], study.model.transverse_gap_mm)
    texts = {
        axis.name: ", ".join(value_text(axis, value) for value in axes[axis.name])
        for axis in axes_of(demands.columns)
    }
    return {
        "title": f"{answer.title_of(table)}{on_suites}",
        "subtitle": subtitle(demands, str(curves["im"].iloc[0])),
        "sketch": drawn,
        "axis_texts": texts,
        "bridges": [
            {
                "name": bridge.name,
                "words": bridge_words(bridge),
                "title": bridge.title,
                "t1_s": bridge.t1_s,
                "surrogate": bridge.details == "surrogate",
            }
            for bridge in bridges
        ],
        "answer": answer_rows(table, counts),
        "failures": answer.failure_sentences(counts),
        "motions_line": f"{answer.motions_sentence(frames['suite'], table)} "
        f"{answer.properties_sentence(demands)} {suites_text}",
    }


def answer_rows(table: pd.DataFrame, counts: pd.DataFrame) -> dict[str, Any]:
    """Return the answer as a table: a row per change and model, the leading states as columns.

    Args:
        table: Table of `answer_table`.
        counts: Table of `run_counts`.
    """
    names = answer.short_names(table) if len(table) else {}
    medians = table[(table["quantity"] == MEDIAN_CAPACITY) & (table["status"] == OK)]
    ends = np.abs(np.log(medians[["ci_low", "ci_high"]].to_numpy(dtype=np.float64)))
    reach = min(float(np.nanmax(ends, initial=0.05)), np.log(_WIDEST_BAR))
    present = list(dict.fromkeys(table.loc[table["quantity"] == MEDIAN_CAPACITY, "demand"]))
    states = sorted(present, key=lambda state: state not in answer.LEADING_STATES)[:2]
    rows: list[dict[str, Any]] = []
    for key, part in table.groupby(["axis", "from_value", "to_value"], sort=False):
        change = change_name(str(key[0]), float(str(key[1])), float(str(key[2])))
        for (bridge, abutment), own in part.groupby(["bridge", "abutment"], sort=False):
            records = {row["demand"]: row for row in records_of(own)}
            same = (counts["bridge"] == bridge) & (counts["abutment"] == abutment)
            failed = counts[same & (counts["axis"] == key[0])].sort_values("value")
            demands = [row for name, row in records.items() if "/" not in name]
            clear = answer.clearest(demands)
            at = next((row["im"] for row in demands if np.isfinite(row["im"])), None)
            rows.append(
                {
                    "change": change,
                    "model": names[str(bridge), str(abutment)] if len(names) > 1 else "",
                    "cells": [_answer_cell(records.get(state), reach) for state in states],
                    "failed": f"{failed['n_failed'].iloc[0]} to {failed['n_failed'].iloc[-1]} of "
                    f"{failed['n_runs'].iloc[0]}"
                    if len(failed) > 1
                    else "–",
                    "clearest": answer.demand_clause(clear)
                    if clear
                    else f"none is certain at {answer.intensity(at)}"
                    if at
                    else "not estimable",
                }
            )
    level = table["level"].dropna()
    margin = table.loc[table["quantity"] == MEDIAN_CAPACITY, "margin"].dropna()
    return {
        "states": [effect_name(state) for state in states],
        "rows": rows,
        "level": f"{100 * level.iloc[0]:g} %" if len(level) else "",
        "margin": f"{100 * margin.iloc[0]:g} %" if len(margin) else "",
    }


def _answer_cell(row: Mapping[str, Any] | None, reach: float) -> dict[str, Any]:
    """Return change, sizes, interval, certainty and bar of a median capacity.

    Positions of the bar are in per cent of its width, which spans ln ratios from -reach to reach.
    """
    if row is None or row["status"] != OK:
        reached = row is not None and row["status"] != answer.NOT_REACHED
        return {"text": "not estimable" if reached else "no run reaches it", "sizes": ""}
    styled = dict(row) | {"verdict_family": row["claim"], "judged_by": RATIO}
    style = verdict_style(styled)
    share = [
        round(50.0 + 49.0 * float(np.clip(np.log(row[end]) / reach, -1.0, 1.0)), 1)
        for end in ("ci_low", "ratio", "ci_high")
    ]
    sizes = [f"{row[f'{end}_demand']:.2f}" for end in ("from", "to")]
    return {
        "text": change_text(styled),
        "sign": style.sign,
        "style": style.name,
        "interval": interval_text(styled),
        "certainty": answer.CERTAINTY[str(row["claim"])],
        "sizes": f"{sizes[0]} → {sizes[1]} g",
        "bar": share,
    }


def _effect_parts(frames: Mapping[str, pd.DataFrame]) -> dict[str, Any]:
    """Return the tables of verdicts: pooled, and for every pair of variants."""
    rows = pd.concat([frames["medians"], frames["effects"]], ignore_index=True)
    rows = rows.sort_values("quantity", key=lambda names: names != MEDIAN_CAPACITY, kind="stable")
    pooled, pairs = (rows[rows["scope"] == scope] for scope in ("pooled", "variant"))
    ratios = pooled[pooled["judged_by"] == RATIO]
    by_pair: list[dict[str, Any]] = []
    for (bridge, abutment, name), own in pairs.groupby(["bridge", "abutment", "axis"], sort=False):
        others = [axis for axis in shown_axes(own) if axis.name != name]
        table = verdict_table(own, [*others])
        label = axes_of([str(name)])[0].label
        by_pair.append(table | {"name": f"{label}, {model_name(bridge, abutment)}"})
    table = verdict_table(pooled, [])
    headline, others = (
        table | {"rows": [row for row in table["rows"] if row["headline"] == is_headline]}
        for is_headline in (True, False)
    )
    return {
        "effects": headline if headline["rows"] else table,
        "other_effects": others if headline["rows"] else headline,
        "pairs": by_pair,
        "margin": margin_text(ratios.iloc[0]) if len(ratios) else "",
        "needed": needed_sentences(frames["needed_motions"]),
        "styles": STYLES.values(),
        "axis_colours": AXIS_COLOURS,
        "legend": LEGEND,
    }


def verdict_table(effects: pd.DataFrame, others: Sequence[Any]) -> dict[str, Any]:
    """Return effects as a table: models over changes as heads, a row per capacity or demand.

    Args:
        effects: Effects on median capacities and demands.
        others: Axes whose values are named in the heads, besides the change.
    """
    keys = ["bridge", "abutment", "axis", "from_value", "to_value", *(a.name for a in others)]
    order = {axis.name: place for place, axis in enumerate(axes_of(dict.fromkeys(effects["axis"])))}
    columns = effects[keys].drop_duplicates()
    columns = columns.assign(_axis=columns["axis"].map(order)).sort_values(
        ["bridge", "abutment", "_axis", *keys[3:]], kind="stable"
    )
    heads = [tuple(row) for row in columns[keys].itertuples(index=False, name=None)]
    models = [model_name(*head[:2]) for head in heads]
    headline = {*HEADLINE_STATES, *demands_for("headline")}
    table: list[dict[str, Any]] = []
    for demand, own in effects.groupby("demand", sort=False):
        cells = {tuple(row[name] for name in keys): _cell(row) for row in records_of(own)}
        label = f"Median, {effect_name(str(demand))}" if "/" in str(demand) else ""
        table.append(
            {
                "label": label or demand_name(str(demand)),
                "margin": margin_text(own.iloc[0]),
                "cells": [cells.get(head) for head in heads],
                "headline": str(demand) in headline,
            }
        )
    return {
        "models": [(model, models.count(model)) for model in dict.fromkeys(models)],
        "heads": [
            ", ".join([change_name(*head[2:5]), *(
                named_value(axis, value) for axis, value in zip(others, head[5:], strict=True)
            )])
            for head in heads
        ],
        "rows": table,
    }  # fmt: skip


def _cell(row: Mapping[str, Any]) -> dict[str, str]:
    style = verdict_style(row)
    has_estimate = row["status"] == OK
    return {
        "style": style.name,
        "sign": style.sign,
        "text": change_text(row) if has_estimate else "not estimable",
        "interval": interval_text(row) if has_estimate else "",
    }


def _table_parts(frames: Mapping[str, pd.DataFrame], study: StudyConfig) -> dict[str, Any]:
    """Return the tables of fragility, of the whole bridge and of intensity measures."""
    curves = frames["curves"]
    return {
        "paper": paper_rows(curves, frames["medians"], frames["joint"]),
        "methods_line": methods_line(curves),
        "fits": fit_counts(curves),
        "unreached": states_not_reached(curves),
        "predict_line": predict_line(frames.get("check_predict")),
        "system": shown_rows(system_rows(frames["system"])),
        "shear_models": shear_model_rows(frames["demands"], study.fragility),
        "measures": shown_rows(measure_rows(frames["measures"])),
    }


def _quality_parts(
    frames: Mapping[str, pd.DataFrame], checks: Mapping[str, Any], study: StudyConfig
) -> dict[str, Any]:
    """Return statuses, checks, accuracy and suspect rows."""
    demands, sensitivity = frames["demands"], frames["sensitivity"]
    return {
        "checks": checks,
        "facts": quality_facts(demands, checks, sensitivity),
        "suspect": shown_rows(checks["suspect"]),
        "rungs": shown_rows(checks["rungs"]),
        "input_notes": shown_rows(records_of(frames["input_notes"])),
        "statuses": [(status, int((demands["status"] == status).sum())) for status in STATUSES],
        "recovered": int((demands["recovery_rung"] > 0).sum()),
        "friction_excess": friction_excess(demands),
        "suspects": suspect_line(demands, excluded=study.fragility.exclude_suspect),
        "sensitivity_line": sensitivity_line(sensitivity),
        "sensitivity": shown_rows(records_of(sensitivity), 4),
        "contact_checks": shown_rows(records_of(frames["contact_checks"]), 6),
        "cpu_h": float(demands["cpu_s"].sum()) / 3600.0,
    }


def shown_rows(rows: Sequence[Mapping[str, Any]], digits: int = 3) -> list[dict[str, str]]:
    """Return the rows of a table in words: heads with the shown units, numbers in these units."""
    shown: list[dict[str, str]] = []
    for row in rows:
        texts: dict[str, str] = {}
        for name, value in row.items():
            words, unit = split_unit(name)
            unit, factor = shown_unit(unit)
            head = words.replace("_", " ") + ("" if unit == "-" else f" ({unit})")
            is_converted = factor != 1.0 and isinstance(value, int | float)
            texts[head] = _number(factor * value if is_converted else value, digits)
        shown.append(texts)
    return shown


def _explorer(frames: Mapping[str, pd.DataFrame], units: str) -> dict[str, str]:
    """Return data and plotting library of the explorer; empty without a curve."""
    if not (frames["curves"]["status"] == FITTED).any():
        return {}
    data = explorer_data(
        frames["demands"], frames["curves"], frames["effects"], frames["medians"], units
    )
    return {"data": data, "library": library()}


def _choices(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the findings and the rows of every bridge and abutment model."""
    return [
        {
            "model": model_name(bridge, abutment),
            "findings": choice_findings(own),
            "left_out": choices_left_out(own),
            "pairs": int(own["n_pairs"].max()),
            "rows": shown_rows(records_of(own.drop(columns=["bridge", "abutment"]))),
        }
        for (bridge, abutment), own in table.groupby(["bridge", "abutment"], sort=False)
    ]


def _number(value: object, digits: int = 3) -> str:
    if value is None or value is pd.NA or value != value:
        return "–"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(str(item) for item in value)
    return str(value)


def _unbroken(text: str) -> str:
    """Return a text without line breaks between a number and its unit."""
    return re.sub(r"(?<=\d) (?=(%|mm|in|mrad|motions)\b|%)", "\u00a0", text)


# The files have 300 dots per inch for print, a screen shows half of them.
# Lossless WebP with few shades is smaller than lossy WebP of quality 40, and its texts are sharp.
# As SVG the figures of two bridges take 10 MB; files for papers lie in the folder of the figures.
_PACKING: Final[dict[str, Any]] = {"format": "webp", "lossless": True, "quality": 60, "method": 2}
_STEP: Final = 255 / 11  # between two of the twelve shades of each primary colour
_SHADES: Final = [round(round(shade / _STEP) * _STEP) for shade in range(256)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure in the page: its caption, the address that holds it, and its size in pixels."""

    caption: Caption
    data: str
    width: int
    height: int


def pictures_of(captions: Sequence[Caption], folder: Path) -> list[Picture]:
    """Return the figures of a folder in the order of `SECTIONS`."""
    shown = sorted(captions, key=lambda caption: SECTIONS.index(caption.section))
    packed: Any = Parallel(n_jobs=2, backend="threading")(
        delayed(_packed)(folder / f"{caption.name}.png") for caption in shown
    )
    return [
        Picture(caption=caption, data=data, width=width, height=height)
        for caption, (data, width, height) in zip(shown, packed, strict=True)
    ]


def _packed(path: Path) -> tuple[str, int, int]:
    with Image.open(path) as drawn:
        picture = drawn.convert("RGB").reduce(2).point(_SHADES * 3)
    packed = BytesIO()
    picture.save(packed, **_PACKING)
    data = base64.b64encode(packed.getvalue()).decode()
    return f"data:image/webp;base64,{data}", *picture.size


type Row = Mapping[str, Any]

_PROPERTIES: Final = {
    "magnitude": "magnitude",
    "ln_distance": "source distance",
    "ln_scale": "scale factor",
    "ln_duration": "duration",
    "ln_shape": "spectral shape Sa(T1)/Sa,avg",
}


def subtitle(demands: pd.DataFrame, im: str) -> str:
    """Return models, axes with their values, motions and their range in one line."""
    bridges = ", ".join(dict.fromkeys(demands["bridge"]))
    models = ", ".join(str(name).replace("_", "-") for name in dict.fromkeys(demands["abutment"]))
    axes = [
        f"{axis.label.lower()} {', '.join(value_text(axis, value) for value in values)}"
        for axis in axes_of(demands.columns)
        if (values := sorted(demands[axis.name].unique()))
    ]
    motions = demands["motion_id"].nunique()
    low, high = demands["scale"].min(), demands["scale"].max()
    scaled = "unscaled" if low == high == 1.0 else f"scaled by {low:.2g} to {high:.2g}"
    span = f"{demands[im].min():.2g} to {demands[im].max():.2g}"
    return (
        f"{bridges} with {models} abutments · {' × '.join(axes)} · "
        f"{motions} motion{'s' if motions > 1 else ''} {scaled}, {plain_label(im)} {span}"
    )


def quality_facts(demands: pd.DataFrame, checks: Row, sensitivity: pd.DataFrame) -> list[str]:
    """Return the quality of the numbers: checks, energy, suspect rows, accuracy."""
    residual = 100.0 * demands["energy_residual_ratio"].abs()
    passed = sum(check["passed"] for check in checks["checks"])
    texts = [
        "Accuracy not compared with the reference",
        f"Energy residual: median {residual.median():.2g} %, worst {residual.max():.2g} %",
        f"{passed} of {len(checks['checks'])} checks of the tables passed",
        f"{checks['suspect_rows']} suspect rows",
    ]
    if len(sensitivity):
        changes = 100.0 * sensitivity["reference_largest_change"]
        texts[0] = (
            f"Demands differ from the reference accuracy by {changes.median():.2g} % (median), "
            f"{changes.max():.2g} % at worst"
        )
    return texts


def friction_excess(demands: pd.DataFrame) -> str:
    """Return the share of the friction work done above the friction limit of its step."""
    name = "cone_work_over_10pct_ratio"
    rubbed = demands[demands["slip_work_kj"] > 0.0]
    if rubbed.empty or name not in rubbed:
        return ""
    share = 100.0 * rubbed[name]
    return (
        "The friction limit of a step is set before the step, so it lags by one or two steps at an "
        f"impact. In the {len(rubbed)} analyses with friction work, the share of that work with "
        f"friction 10 % or more above the local limit has a median of {share.median():.2g} % and a "
        f"95th percentile of {share.quantile(0.95):.2g} %; the worst is {share.max():.2g} %."
    )


def suspect_line(demands: pd.DataFrame, *, excluded: bool) -> str:
    """Return the number of suspect rows and their treatment in the fits."""
    count = int((demands[SUSPECT] != "").sum())
    if not count:
        return f"None of the {len(demands)} rows is suspect."
    use = "as failed analyses" if excluded else "like all others"
    return f"{count} of {len(demands)} rows are suspect; the fits use them {use}."


def sensitivity_line(table: pd.DataFrame) -> str:
    """Return what the table of the accuracy compares; empty without one."""
    if table.empty:
        return ""
    return (
        f"Ratios of the peak demands of {table['rows'].max()} rows of the study to those at the "
        "reference accuracy (mean), and the largest change of a single row: against the reference, "
        "and with a contact penalty (normal kn, tangential kt) halved and doubled. Both sides of "
        "every comparison are analysed for the strongest part of the motion only, "
        f"{table['analysed_s'].max():.3g} s."
    )


def needed_sentences(needed: pd.DataFrame) -> list[str]:
    """Return for each axis how many motions would decide the effects that are undecided."""
    open_rows = needed[needed["forecast"] == MORE]
    return [
        f"{change_name(str(key[0]), float(str(key[1])), float(str(key[2])))}: "
        + listed(
            f"{effect_name(row['demand'])} of {row['bridge']} {row['needed_motions']:.0f}"
            for row in records_of(own.sort_values("needed_motions"))
        )
        + " motions."
        for key, own in open_rows.groupby(["axis", "from_value", "to_value"], sort=False)
    ]


def paper_rows(curves: pd.DataFrame, medians: pd.DataFrame, joint: pd.DataFrame) -> dict[str, Any]:
    """Return the fragility table for publication: heads, groups of rows by model and state.

    Args:
        curves: Fits of the single variants.
        medians: Paired ratios of their medians.
        joint: Joint models.
    """
    table = paper_table(curves, medians, joint)
    texts, ratios = printed_rows(table), ratio_names(table)
    variants = {row["variant"]: row for row in records_of(curves)}
    shown = shown_axes(curves)
    states = records_of(curves.drop_duplicates(["component", "limit_state"]))
    capacity = {
        (row["component"], row["limit_state"]): threshold_text(row["demand"], row["threshold"])
        for row in states
    }
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row, text in zip(records_of(table), texts, strict=True):
        where = variants.get(row["row"])
        limit = capacity[row["component"], row["limit_state"]]
        theta = text["theta"]
        if pd.isna(row["theta"]):
            theta = "none exceeds" if row["n_exceed"] == 0 else "outcomes give no median"
            theta = "all exceed" if row["n_exceed"] == row["n_runs"] else theta
        groups.setdefault(
            (model_name(row["bridge"], row["abutment"]), f"{text['state']} ({limit})"), []
        ).append(
            {
                "variant": "all variants, middle of the range"
                if where is None
                else ", ".join(named_value(axis, where[axis.name]) for axis in shown),
                "joint": row["row"] == JOINT,
                "theta": theta,
                **{name: text[name] for name in ("beta", "total", "exceed")},
                "ratios": [text[name] for name in ratios],
            }
        )
    return {
        "im": plain_label(str(curves["im"].iloc[0])),
        "level": float(curves["level"].iloc[0]),
        "ratios": [f"θ ratio, {in_words(name)}" for name in ratios],
        "groups": [
            {"model": model, "state": state, "rows": rows}
            for (model, state), rows in groups.items()
        ],
    }


def methods_line(curves: pd.DataFrame) -> str:
    """Return how often cloud and exceedance medians differ, and which of them is used."""
    both = curves[(curves["method"] == "cloud") & curves["methods_ratio"].notna()]
    differing = both[both["methods_differ"].eq(other=True)]
    cells = curves[curves["preferred"].eq(other=True) & curves["methods_differ"].eq(other=True)]
    exceedance = int((cells["method"] == "exceedance").sum())
    rule = (
        "The median used everywhere is that of the cloud, because it uses the size of every "
        "demand; where both differ by more than 2 standard errors and at least 5 runs lie on each "
        "side of the state, it is that of the exceedance fit, which does not assume a line"
    )
    return (
        f"In {len(differing)} of {len(both)} variants and states with both fits, the cloud and the "
        "exceedance medians differ by more than 15 % or 2 standard errors (marked *). "
        f"{rule} ({exceedance} of the {len(cells)} marked medians)."
    )


def states_not_reached(curves: pd.DataFrame) -> list[dict[str, str]]:
    """Return the states that no run of some variants reached, with the largest demand."""
    listed_rows = curves[(curves["reach"].fillna("") != "") & (curves["method"] == "cloud")]
    keys = ["bridge", "abutment", "component", "limit_state"]
    out: list[dict[str, str]] = []
    for (bridge, abutment, component, state), own in listed_rows.groupby(keys, sort=False):
        same = (curves["bridge"] == bridge) & (curves["abutment"] == abutment)
        first = own.iloc[0]
        out.append(
            {
                "model": model_name(bridge, abutment),
                "state": in_words(f"{component}, {state}"),
                "variants": f"{len(own)} of {curves.loc[same, 'variant'].nunique()}",
                "where": ", ".join(
                    named_value(axis, first[axis.name]) for axis in axes_of(own.columns)
                ),
                "reason": str(first["reach"]),
            }
        )
    return out


def fit_counts(curves: pd.DataFrame) -> list[tuple[str, int]]:
    """Return how many fits have each status, estimates first."""
    counts = curves["status"].astype(str).value_counts()
    names = sorted(counts.index, key=lambda name: name != FITTED)
    return [(in_words(name), int(counts[name])) for name in names]


def system_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the medians of the whole bridge with their bounds."""
    if table.empty:
        return []
    axes = shown_axes(table)
    return [
        {
            "model": model_name(row["bridge"], row["abutment"]),
            "variant": ", ".join(named_value(each, row[each.name]) for each in axes),
            "degree of damage": row["limit_state"],
            "exceed": f"{row['n_exceed']} of {row['n_runs']}",
            "θ [interval]": with_interval([row[f"theta{end}"] for end in ("", "_low", "_high")])
            if row["status"] == FITTED
            else in_words(row["status"]),
            "β": row["beta"],
            "θ, components fully correlated": row["theta_correlated"],
            "θ, components independent": row["theta_independent"],
            "weakest component": in_words(row["weakest"]),
        }
        for row in records_of(table)
    ]


def shear_model_rows(demands: pd.DataFrame, settings: FitSettings) -> list[dict[str, str]]:
    """Return the median capacity for shear failure of each variant under each shear model."""
    curves = shear_model_medians(demands, settings)
    axes = shown_axes(curves)
    return [
        {
            "model": model_name(str(bridge), str(abutment)),
            "variant": ", ".join(named_value(each, own[each.name].iloc[0]) for each in axes),
            **{
                f"{SHEAR_MODELS[row['limit_state']]}, θ [interval]": with_interval(
                    [row[f"theta{end}"] for end in ("", "_low", "_high")]
                )
                if row["status"] == FITTED
                else f"{row['n_exceed']} of {row['n_runs']} runs fail"
                for row in records_of(own)
            },
        }
        for (bridge, abutment, _), own in curves.groupby(
            ["bridge", "abutment", "variant"], sort=False
        )
    ]


def measure_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the intensity measures in the order of their rank for each demand."""
    return [
        {
            "model": model_name(row["bridge"], row["abutment"]),
            "demand": demand_name(row["demand"]),
            "measure": plain_label(row["im"]),
            "recommended": "yes" if row["recommended"] else "",
            "proficiency s/b": row["proficiency"],
            "efficiency s": row["efficiency"],
            "practicality b": row["practicality"],
            "R²": row["r2"],
            **{
                f"p, {text}": row[f"p_{name}"]
                for name, text in _PROPERTIES.items()
                if f"p_{name}" in row
            },
            "chance of being best": row["p_best_proficiency"],
        }
        for row in records_of(table)
    ]


def predict_line(check: pd.DataFrame | None) -> str:
    """Return the error of `predict` inside the grid; how to measure it without the table."""
    if check is None:
        return "Error of predict inside the grid: not measured (make check-predict)."
    compared = check[check["status"] == OK]
    if compared.empty:
        return "Error of predict inside the grid: no state with an estimate to compare."
    error = 100.0 * compared["error"].abs()
    worst = compared.loc[error.idxmax()]
    return (
        f"Error of predict inside the grid, from new analyses of {compared['variant'].nunique()} "
        f"variants under {compared['n_motions'].max():.0f} motions: median {error.median():.2g} % "
        f"over {len(compared)} medians, worst {error.max():.2g} % "
        f"({in_words(worst['component'] + ', ' + worst['limit_state'])})."
    )

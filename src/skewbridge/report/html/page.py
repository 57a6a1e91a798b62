"""The report: tables and figures of a study joined in one self-contained HTML file."""

import base64
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined
from joblib import Parallel, delayed
from matplotlib.image import imread, imsave
from numpy.typing import NDArray

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.demands.suspect import SUSPECT
from skewbridge.files.tables import read_frame, read_stamp, records_of
from skewbridge.files.text import write_text
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.paper_table import (
    JOINT,
    paper_table,
    printed_rows,
    ratio_names,
    with_interval,
)
from skewbridge.fragility.verdicts import MORE, OK
from skewbridge.report import answer
from skewbridge.report.answer import (
    change_name,
    effect_name,
    headline_rows,
    listed,
    model_name,
    number,
    short_names,
)
from skewbridge.report.axis_layout import (
    named_value,
    plain_label,
    shown_axes,
    threshold_text,
    value_text,
)
from skewbridge.report.effect_figures import choice_findings, choices_left_out
from skewbridge.report.html.explorer import explorer_data, library
from skewbridge.report.methods import STATE_HEADS, methods_of
from skewbridge.report.study_figures import (
    CHOICES,
    CLOUDS,
    CURVES,
    EFFECTS,
    HISTORIES,
    MOTIONS,
    Caption,
    read_captions,
)
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
from skewbridge.study.config import parse_config
from skewbridge.variant.axes import axes_of

#: In the order of the page.
_SECTIONS: Final = (CURVES, CLOUDS, EFFECTS, CHOICES, MOTIONS, HISTORIES)


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
    demands, curves, effects = (frames[name] for name in ("demands", "curves", "effects"))
    pooled = effects[effects["scope"] == "pooled"]
    pooled_medians = frames["medians"][frames["medians"]["scope"] == "pooled"]
    checks = json.loads(tables["checks"].read_text(encoding="utf-8"))
    im = str(curves["im"].iloc[0])
    table = answer.answer_table(
        medians=frames["medians"],
        effects=effects,
        intensities=frames["intensity_effects"],
        curves=curves,
    )
    table, counts = answer.with_seats(table, demands), answer.run_counts(demands)
    environment = Environment(
        loader=PackageLoader("skewbridge.report.html"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters |= {"number": _number, "head": _head, "unbroken": _unbroken}
    page = environment.get_template("report.html.j2").render(
        title=answer.title_of(table),
        subtitle=subtitle(demands, im),
        failures=answer.failure_sentence(counts),
        motions_line=answer.motions_sentence(frames["suite"], table),
        chips=chips(demands, checks, frames["sensitivity"]),
        bridges=bridge_lines([load_bridge(name) for name in sorted(config["grid"]["bridge"])]),
        cards=_cards(table, counts),
        maps=verdict_maps(pd.concat([pooled_medians, pooled], ignore_index=True)),
        needed=needed_sentences(frames["needed_motions"]),
        effect=_effect_words(pooled),
        styles=STYLES.values(),
        legend=LEGEND,
        paper=paper_rows(curves, frames["medians"], frames["joint"]),
        methods_line=methods_line(curves),
        fits=fit_counts(curves),
        unreached=states_not_reached(curves),
        predict_line=predict_line(frames.get("check_predict")),
        input_notes=frames["input_notes"].to_dict("records"),
        explorer=_explorer(demands, curves, effects, frames["medians"]),
        pictures=pictures_of(read_captions(tables["captions"]), figures, _SECTIONS),
        statuses=[(status, int((demands["status"] == status).sum())) for status in STATUSES],
        recovered=int((demands["recovery_rung"] > 0).sum()),
        friction_excess=friction_excess(demands),
        suspects=suspect_line(demands, excluded=config["fragility"]["exclude_suspect"]),
        checks=checks,
        methods=methods_of(parse_config(config), frames["suite"]),
        state_heads=STATE_HEADS,
        sensitivity_line=sensitivity_line(frames["sensitivity"]),
        cpu_h=float(demands["cpu_s"].sum()) / 3600.0,
        choices=[] if choices is None else _choices(read_frame(choices)),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        system=system_rows(frames["system"]),
        measures=measure_rows(frames["measures"]),
        measure_lines=measure_sentences(frames["measures"], im),
        provenance=dict(sorted(read_stamp(tables["demands"]).items())),
        **{name: frames[name].to_dict("records") for name in ("contact_checks", "sensitivity")},
    )
    write_text(output, page)


def _cards(table: pd.DataFrame, counts: pd.DataFrame) -> list[dict[str, Any]]:
    """Return a card per axis: its change, sentences for each model, and its part of the plot."""
    forest, names = Forest(table), answer.short_names(table)
    cards: list[dict[str, Any]] = []
    for key, part in table.groupby(["axis", "from_value", "to_value"], sort=False):
        sentences: list[tuple[str, list[str]]] = []
        for (bridge, abutment), rows in part.groupby(["bridge", "abutment"], sort=False):
            own = counts["axis"] == key[0]
            for name, value in (("bridge", bridge), ("abutment", abutment)):
                own &= counts[name] == value
            shown = names[str(bridge), str(abutment)] if len(names) > 1 else ""
            sentences.append((shown, answer.card_sentences(rows, counts[own])))
        cards.append(
            {
                "title": answer.change_name(str(key[0]), float(str(key[1])), float(str(key[2]))),
                "sentences": sentences,
                "plot": forest.plot(part),
            }
        )
    return cards


def _explorer(
    demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame, medians: pd.DataFrame
) -> dict[str, str]:
    """Return data and plotting library of the explorer; empty without a curve."""
    if not (curves["status"] == FITTED).any():
        return {}
    return {"data": explorer_data(demands, curves, effects, medians), "library": library()}


def _effect_words(pooled: pd.DataFrame) -> dict[str, str]:
    """Return level and margin of the effects in words; empty without effects."""
    ratios = pooled[pooled["judged_by"] == "ratio"]
    if ratios.empty:
        return {"level": "", "margin": ""}
    first = ratios.iloc[0]
    return {"level": f"{100 * first['level']:g} %", "margin": margin_text(first)}


def _choices(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the findings and the rows of every bridge and abutment model."""
    return [
        {
            "model": answer.model_name(bridge, abutment),
            "findings": choice_findings(own),
            "left_out": choices_left_out(own),
            "pairs": int(own["n_pairs"].max()),
            "rows": own.drop(columns=["bridge", "abutment"]).to_dict("records"),
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
    return re.sub(r"(?<=\d) (?=(%|mm|mrad|motions)\b|%)", "\u00a0", text)


def _head(name: str) -> str:
    """Return the name of a column in words, its unit in brackets."""
    for unit, shown in (("_kn", "kN"), ("_mm", "mm"), ("_deg", "°"), ("_m", "m"), ("_s", "s")):
        if name.endswith(unit):
            return f"{name.removesuffix(unit).replace('_', ' ')} ({shown})"
    return name.replace("_", " ")


# The files have 300 dots per inch for print, a screen shows half of them.
# Lossless WebP with few shades is smaller than lossy WebP of quality 40, and its texts are sharp.
# As SVG the figures of two bridges take 10 MB; files for papers lie in the folder of the figures.
_PACKING: Final = {"lossless": True, "quality": 60, "method": 4}
_SHADES: Final = 12  # levels of each primary colour


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure in the page.

    Attributes:
        number: Its number, from 1, in the order of the page.
        caption: Its caption.
        data: Address that holds the whole picture.
        width: In pixels.
        height: In pixels.
    """

    number: int
    caption: Caption
    data: str
    width: int
    height: int


def pictures_of(
    captions: Sequence[Caption], folder: Path, order: Sequence[str]
) -> dict[str, list[Picture]]:
    """Return the figures by section, numbered in the order of the page.

    Args:
        captions: Captions of all figures.
        folder: Folder with a PNG file of each.
        order: Sections in the order of the page.
    """
    packed: Any = Parallel(n_jobs=2, backend="threading")(
        delayed(_packed)(folder / f"{caption.name}.png") for caption in captions
    )
    found: dict[str, list[Picture]] = {section: [] for section in order}
    shown = sorted(
        zip(captions, packed, strict=True), key=lambda pair: order.index(pair[0].section)
    )
    for place, (caption, (data, width, height)) in enumerate(shown, start=1):
        picture = Picture(number=place, caption=caption, data=data, width=width, height=height)
        found[caption.section].append(picture)
    return found


def _packed(path: Path) -> tuple[str, int, int]:
    pixels = np.round(_halved(imread(path)) * (_SHADES - 1)) / (_SHADES - 1)
    packed = BytesIO()
    imsave(packed, pixels, format="webp", pil_kwargs=_PACKING)
    data = base64.b64encode(packed.getvalue()).decode()
    return f"data:image/webp;base64,{data}", pixels.shape[1], pixels.shape[0]


def _halved(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a picture of half the width and height, each pixel the mean of four."""
    height, width = (2 * (size // 2) for size in pixels.shape[:2])
    blocks = pixels[:height, :width, :3].reshape(height // 2, 2, width // 2, 2, 3)
    return blocks.mean(axis=(1, 3))


type Row = Mapping[str, Any]

#: Largest p-value at which the dependence of residuals on a property is reported.
_SUFFICIENT: Final = 0.01
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


def chips(demands: pd.DataFrame, checks: Row, sensitivity: pd.DataFrame) -> list[str]:
    """Return the quality of the numbers: checks, energy, suspect rows, accuracy."""
    residual = 100.0 * demands["energy_residual_ratio"].abs()
    passed = sum(check["passed"] for check in checks["checks"])
    texts = [
        f"{passed} of {len(checks['checks'])} checks of the tables passed",
        f"energy residual: median {residual.median():.2g} %, worst {residual.max():.2g} %",
        f"suspect rows: {checks['suspect_rows']}",
    ]
    if len(sensitivity):
        changes = 100.0 * sensitivity["reference_largest_change"]
        texts.append(
            f"against the reference accuracy: median {changes.median():.2g} %, worst "
            f"{changes.max():.2g} %"
        )
    return texts


def bridge_lines(bridges: Sequence[BridgeData]) -> list[dict[str, Any]]:
    """Return title, name and facts of every bridge."""
    return [
        {
            "title": bridge.title,
            "name": bridge.name,
            "facts": f"{bridge.base} column bases, conditioning period T1 = {bridge.t1_s:.3g} s",
            "surrogate": bridge.details == "surrogate",
        }
        for bridge in bridges
    ]


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


def verdict_maps(pooled: pd.DataFrame) -> list[dict[str, Any]]:
    """Return a map per bridge and abutment model: heads, and rows of cells.

    Args:
        pooled: Pooled rows of the effects, on median capacities and on demands.
    """
    changes = ["axis", "from_value", "to_value"]
    maps: list[dict[str, Any]] = []
    for model, part in pooled.groupby(["bridge", "abutment"], sort=False):
        heads = list(part[changes].drop_duplicates().itertuples(index=False, name=None))
        rows: list[dict[str, Any]] = []
        for demand, own in part.groupby("demand", sort=False):
            cells = {tuple(row[name] for name in changes): _cell(row) for row in records_of(own)}
            rows.append(
                {
                    "label": f"Median, {effect_name(str(demand))}"
                    if "/" in str(demand)
                    else demand_name(str(demand)),
                    "margin": margin_text(own.iloc[0]),
                    "cells": [cells.get(head) for head in heads],
                }
            )
        names = [change_name(*head) for head in heads]
        maps.append({"model": model_name(*model), "heads": names, "rows": rows})
    return maps


def _cell(row: Row) -> dict[str, str]:
    style = verdict_style(row)
    has_estimate = row["status"] == OK
    return {
        "style": style.name,
        "sign": style.sign,
        "text": change_text(row) if has_estimate else "not estimable",
        "interval": interval_text(row) if has_estimate else "",
    }


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
        "ratios": [f"θ ratio, {name.replace('_', ' ')}" for name in ratios],
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
                "state": f"{component}, {state}".replace("_", " "),
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
    return [(str(name).replace("_", " "), int(counts[name])) for name in names]


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
            else str(row["status"]).replace("_", " "),
            "β": row["beta"],
            "θ, components fully correlated": row["theta_correlated"],
            "θ, components independent": row["theta_independent"],
            "weakest component": str(row["weakest"]).replace("_", " "),
        }
        for row in records_of(table)
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


def measure_sentences(table: pd.DataFrame, im: str) -> list[str]:
    """Return the recommended intensity measure of each model and what residuals depend on.

    Args:
        table: Table `measures`.
        im: Intensity measure of the fits.
    """
    if table.empty or "recommended" not in table:
        return []
    out: list[str] = []
    for model, part in table.groupby(["bridge", "abutment"], sort=False):
        fitted = part[part["status"] == OK]
        best = fitted[fitted["recommended"].eq(other=True)]
        if best.empty:
            continue
        scatter = {
            name: float(np.exp(np.log(fitted.loc[fitted["im"] == name, "efficiency"]).mean()))
            for name in dict.fromkeys([str(best["im"].iloc[0]), im])
            if (fitted["im"] == name).any()
        }
        text = listed(
            f"{plain_label(name)} (mean scatter {number(value)})" for name, value in scatter.items()
        )
        role = "is also that of the fits" if len(scatter) == 1 else "then that of the fits"
        out.append(f"Recommended intensity measure for {model_name(*model)}: {text}; {role}.")
        own = fitted[fitted["im"] == im]
        findings: list[str] = []
        for name, label in _PROPERTIES.items():
            if f"p_{name}" not in own:
                continue
            dependent = own[own[f"p_{name}"] < _SUFFICIENT]
            if dependent.empty:
                continue
            ends = dependent[f"effect_{name}"]
            span = " to ".join(dict.fromkeys(f"{end:+.2f}" for end in (ends.min(), ends.max())))
            findings.append(
                f"{label} in {len(dependent)} of {own[f'p_{name}'].notna().sum()} demands "
                f"({span} in ln demand per standard deviation)"
            )
        if findings:
            out.append(f"Given {plain_label(im)}, its demands still depend on {listed(findings)}.")
        else:
            out.append(f"Given {plain_label(im)}, no dependence at p < {_SUFFICIENT:g} was found.")
    return out


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
        f"({str(worst['component']).replace('_', ' ')}, {worst['limit_state']})."
    )


#: Size of the plot of a card, position of its axis, and its widest range of ratios.
_WIDTH, _LEFT, _RIGHT, _ROW, _TOP = 400.0, 158.0, 334.0, 22.0, 10.0
_REACH: Final = (0.4, 2.5)
_TICKS: Final = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0)
_TICK_ROOM: Final = 30.0


class Forest:
    """Forest plots of the cards on a common logarithmic axis of ratios."""

    def __init__(self, answer: pd.DataFrame) -> None:
        rows = headline_rows(answer)
        self._margin = float(rows["margin"].iloc[0]) if len(rows) else 0.05
        ends = rows[["ci_low", "ratio", "ci_high"]].to_numpy(dtype=np.float64)
        ends = ends[np.isfinite(ends) & (ends > 0.0)]
        low = min([1.0 - 2.5 * self._margin, *ends]) / 1.01
        high = max([1.0 + 2.5 * self._margin, *ends]) * 1.01
        self._low, self._high = np.log(max(low, _REACH[0])), np.log(min(high, _REACH[1]))

    def _x(self, ratio: float) -> float:
        share = (np.log(max(ratio, 1e-9)) - self._low) / (self._high - self._low)
        return round(float(_LEFT + (_RIGHT - _LEFT) * np.clip(share, 0.0, 1.0)), 1)

    def plot(self, rows: pd.DataFrame) -> dict[str, Any]:
        """Return the positions and texts that the template draws for the rows of one axis."""
        drawn = list(self._rows(headline_rows(rows)))
        bottom = _TOP + _ROW * len(drawn)
        return {
            "width": _WIDTH,
            "height": bottom + _TICK_ROOM,
            "top": _TOP - 6.0,
            "bottom": bottom,
            "band": (self._x(1.0 - self._margin), self._x(1.0 + self._margin)),
            "zero": self._x(1.0),
            "ticks": self._ticks(),
            "rows": drawn,
        }

    def _rows(self, shown: pd.DataFrame) -> Iterator[dict[str, Any]]:
        names, line = short_names(shown), 0
        for model, part in shown.groupby(["bridge", "abutment"], sort=False):
            if len(names) > 1:
                head = names[str(model[0]), str(model[1])]
                yield {"y": _TOP + _ROW * (line + 0.5), "head": head}
                line += 1
            for row in records_of(part):
                style = verdict_style(row)
                median = "median, " if "/" in row["demand"] else ""
                yield {
                    "y": _TOP + _ROW * (line + 0.5),
                    "head": "",
                    "label": f"{median}{effect_name(row['demand'])}",
                    "x": [
                        self._x(row[end]) if np.isfinite(row[end]) else None
                        for end in ("ci_low", "ratio", "ci_high")
                    ],
                    "fill": style.fill,
                    "text": change_text(row),
                    "title": f"{style.sign} {change_text(row)}, {interval_text(row)}",
                }
                line += 1

    def _ticks(self) -> list[tuple[float, str]]:
        ticks: list[tuple[float, str]] = [(self._x(1.0), "0")]
        for tick in sorted(_TICKS, key=lambda value: -abs(np.log(value))):
            x = self._x(tick)
            inside = self._low <= np.log(tick) <= self._high
            if inside and all(abs(x - other) > 40.0 for other, _ in ticks):
                ticks.append((x, f"{100 * (tick - 1):+.0f} %"))
        return sorted(ticks)

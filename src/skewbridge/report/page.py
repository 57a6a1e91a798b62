"""Report of a study: tables and figures in one self-contained HTML file."""

import base64
import gzip
import json
import re
from cmath import rect
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from importlib.resources import files
from io import BytesIO
from itertools import product
from math import copysign, cos, radians, sin, tan
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import yaml
from joblib import Parallel, cpu_count, delayed
from PIL import Image
from pydantic_core import to_json

from skewbridge.bridge.frame import Description, Structure
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.plan import PlanVector
from skewbridge.demands.columns import demands_for
from skewbridge.demands.validity import (
    BEYOND_MODEL,
    FAILURE_DEMANDS,
    MAX_ENERGY_RESIDUAL,
    is_complete,
    with_derived_columns,
)
from skewbridge.files.tables import Row, read_frame, read_stamp, records_of, stamp
from skewbridge.files.text import write_text
from skewbridge.fragility import exports, verdicts
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.limit_states import COLUMN_FAILURE, HEADLINE_STATES, hazus_factor
from skewbridge.fragility.verdicts import MEDIAN_CAPACITY, OK
from skewbridge.report import answer, appearance, fragility_figures
from skewbridge.report.answer import change_name, effect_name, model_name
from skewbridge.report.appearance import groups_of, in_words, plain_label, shown_axes, variant_text
from skewbridge.report.fragility_figures import (
    STATE,
    curve_values,
    main_curves,
    pooled_curves,
    state_text,
    with_system,
)
from skewbridge.report.methods import methods_of
from skewbridge.report.study_figures import SECTIONS, Caption, draw_study, read_captions
from skewbridge.statuses import STATUSES
from skewbridge.study.config import CONDITIONING_BRIDGE, FigureSettings, StudyConfig
from skewbridge.study.folder import StudyFolder, last_plan, round_line
from skewbridge.units import Units, split_unit
from skewbridge.variant.axes import axes_of
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import lacking_axes

_CHANGE: Final = ("axis", "from_value", "to_value")


def write_report(
    *,
    tables: Mapping[str, Path],
    figures: Path,
    study: StudyConfig | None,
    output: Path,
    units: Units | None = None,
) -> None:
    """Write the report to an HTML file.

    ``tables`` maps the names in `StudyFolder.report_inputs`, and ``choices`` if made, to paths;
    ``figures`` is a folder. ``study`` is None for tables of `skewbridge statistics`. ``units`` are
    by default those of the study.
    """
    frames = {
        name: read_frame(path)
        for name, path in tables.items()
        if path.suffix == ".parquet" and path.is_file()
    }
    curves = frames["curves"]
    config = study.model_dump(mode="json", exclude={"batches"}) if study else {}
    units = units or (study.figures if study else FigureSettings()).units
    bridges = tuple(dict.fromkeys(study.grid.bridge)) if study else ()
    modules = map(vars, (appearance, answer, fragility_figures))
    environment = appearance.templates(*modules, globals())
    unreached = curves[(curves["reach"].fillna("") != "") & (curves["method"] == "cloud")]
    pictures = pictures_of(read_captions(tables["captions"]), figures)
    has_rounds = study is not None and study.design.until
    plan = last_plan(StudyFolder(tables["demands"].parent)) if has_rounds else None
    leading = {p["caption"].name: p for p in pictures if p["caption"].section == SECTIONS[0]}
    with appearance.shown_in(units):
        page = environment.get_template("report.html.j2").render(
            **_first_screen(frames, bridges),
            **_effect_parts(frames),
            study=study,
            rounds=round_line(plan) if plan else "",
            methods=methods_of(study, frames["suite"]) if study else None,
            checks=json.loads(tables["checks"].read_text("utf-8")) if study else None,
            bridges=[load_structure(name) for name in bridges],
            leading=leading,
            gallery=[picture for picture in pictures if picture not in leading.values()],
            tables=frames,
            unreached=groups_of(unreached, (*BRIDGE_COLUMNS, "component", "limit_state")),
            shear_heads=[
                f"{appearance.shear_model_name(demand)}, θ [interval]"
                for demand in frames["shear_models"]["demand"].unique()
            ],
            provenance=dict(sorted(read_stamp(tables["demands"]).items())),
            config=yaml.safe_dump(config, sort_keys=False),
        )
    write_text(output, page)


def write_statistics_report(results: Path, units: Units = "si") -> Path:
    """Draw the figures and write the page of tables written by `skewbridge statistics`."""
    folder = StudyFolder(results)
    paths = {name: path for name, path in folder.report_inputs.items() if path.is_file()}
    origin, outputs = read_stamp(folder.demands), {"folder": folder.figures}
    outputs["captions"] = paths["captions"] = folder.captions
    settings = FigureSettings(units=units)
    draw_study(paths, **outputs, settings=settings, provenance=origin, n_jobs=cpu_count())
    write_report(
        tables=paths, figures=folder.figures, study=None, output=folder.report, units=units
    )
    stamp(folder.report, origin)
    return folder.report


# --- the first screen


def _first_screen(frames: Mapping[str, pd.DataFrame], bridges: Sequence[str]) -> dict[str, Any]:
    """Return the first screen: answer, failures and motions; ``bridges`` are names or files."""
    demands, curves = frames["demands"], frames["curves"]
    table = answer.answer_table(
        medians=frames["medians"],
        effects=frames["effects"],
        intensities=frames["intensity_effects"],
        curves=curves,
        bridges=bridges,
    )
    counts, colours = answer.run_counts(demands), appearance.VARIANT_COLOURS[1:4]
    axes, structures = axes_of(demands.columns), [load_structure(name) for name in bridges]
    motions = f"{demands['motion_id'].nunique()} motions."
    if "suite" in frames:
        suite, properties = frames["suite"], answer.properties_sentence(demands, structures)
        doubts = answer.motion_doubts(suite, demands)
        motions = f"{answer.motions_sentence(suite, table)} {doubts} {properties}"
    suites_sentence, suites_text = answer.suites_summary(frames["suites"], table)
    of_first = demands[demands["bridge"].isin([bridge.name for bridge in structures[:1]])]
    with_backfill = demands[demands["abutment"].isin(answer.BACKFILLED)]
    varied = [axis.title for axis in axes if (counts["axis"] == axis.name).any()]
    title = f"Fragility of {answer.listed(demands['bridge'].unique())}"
    has_capacities = any(name in demands for name in (*FAILURE_DEMANDS.values(), BEYOND_MODEL))
    return {
        "title": f"{title}: effect of {answer.listed(varied)}" if varied else title,
        "headline": [*answer.headline(table), *filter(None, [suites_sentence])],
        "sketch_colours": dict(zip(("skew", "gap", "friction"), colours, strict=True)),
        "axis_texts": _axis_texts(demands, structures),
        "plan_texts": _axis_texts(of_first, structures[:1]),
        "at_own_period": is_at_own_period(str(curves["im"].iloc[0]), set(demands["bridge"])),
        "answer": answer_rows(table, counts, curves) | {"failures": has_capacities},
        "failures": answer.failure_sentences(counts, has_capacities=has_capacities),
        "shear_failures": answer.shear_model_sentence(demands),
        "motions_line": f"{motions} {suites_text} "
        f"{answer.untested_skew_sentence(with_backfill['skew_deg'])}".rstrip(),
    }


def _axis_texts(demands: pd.DataFrame, bridges: Sequence[Structure]) -> dict[str, str]:
    """Return the values of each axis in a table as text, with those that bridge files state.

    Values of abutment models that lack the axis count only if no other model has it.
    """
    texts: dict[str, str] = {}
    for axis in axes_of(demands.columns):
        models = demands["abutment"].unique()
        having = [name for name in models if axis.name not in lacking_axes(str(name))] or models
        values = demands.loc[demands["abutment"].isin(having), axis.name].unique()
        texts[axis.name] = ", ".join(appearance.value_text(axis, v) for v in sorted(values))
    return answer.texts_with_own(texts, bridges) if bridges else texts


def answer_rows(table: pd.DataFrame, counts: pd.DataFrame, curves: pd.DataFrame) -> dict[str, Any]:
    """Return the table of the first screen: one row per change and model, one column per state.

    ``table`` is from `answer_table`, ``counts`` from `run_counts`; ``curves`` have the capacities.
    """
    heads = {
        f"{row['component']}/{row['limit_state']}": state_text(row) for row in records_of(curves)
    }
    names = answer.distinct_names(table)
    capacities = table[table["quantity"] == MEDIAN_CAPACITY]
    states_present = capacities["demand"].unique()
    states = sorted(states_present, key=lambda state: state not in answer.LEADING_STATES)
    states = states[: max(2, sum(state in answer.LEADING_STATES for state in states))]
    printed = capacities[capacities["demand"].isin(states)]
    by_value = dict(groups_of(counts, (*BRIDGE_COLUMNS, "axis")))
    rows: list[dict[str, Any]] = []
    for change, change_rows in groups_of(table, _CHANGE):
        for model, model_rows in groups_of(change_rows, BRIDGE_COLUMNS):
            with_verdicts = model_rows.assign(verdict_family=model_rows["claim"])
            effects = {row["demand"]: row for row in records_of(with_verdicts)}
            counts_of = by_value[*model, change[0]].set_index("value").loc[list(change[1:])]
            (first, runs), (last, last_runs) = counts_of[["n_failed", "n_runs"]].to_numpy()
            of_first = f" of {runs}" if runs != last_runs else ""
            row = {
                "change": change_name(*change),
                "model": names[model],
                "failed": f"{first}{of_first} to {last} of {last_runs}",
            }
            rows.append({**row, "cells": [effects.get(state) for state in states]})
    return {
        "states": [heads[state] for state in states],
        "certainty": answer.SHORT_CERTAINTY,
        "rows": rows,
        "extents": " ".join(map(answer.extent_of_data, records_of(printed))),
        "details": answer.effect_notes(table),
        "level": next((f"{100 * level:g} %" for level in table["level"].dropna()), ""),
        "margin": next((f"{100 * margin:g} %" for margin in capacities["margin"].dropna()), ""),
    }


def motion_notes(suite: pd.DataFrame) -> list[Row]:
    """Return the notes of the reader on the motions, one row each."""
    texts = dict(zip(suite["motion_id"], suite["messages"], strict=True))
    return [{"motion": name, "note": text} for name in texts for text in json.loads(texts[name])]


def is_at_own_period(im: str, bridges: Collection[str]) -> bool:
    """Return whether ``im`` uses T1 of each bridge, while scale factors use that of one bridge."""
    return im.startswith(("im_saavg", "im_sa_t1")) and set(bridges) != {CONDITIONING_BRIDGE}


def bridge_words(bridge: Description) -> str:
    """Return a bridge in words, such as ``two spans, pinned two-column bent``."""
    bents = Counter(zip(bridge.bent_bases, bridge.bent_columns, strict=True))
    ends = [f"{kind} {name} end" for name, kind in bridge.end_kinds.items()]
    only_seats = {*bridge.end_kinds.values()} == {"seat"}
    return answer.sentence("bridge", bridge=bridge, bents=bents, ends=[] if only_seats else ends)


#: Size of the plan in units of the SVG, and margins around the bridge for walls and texts.
_WIDTH, _HEIGHT, _SIDE, _TOP = 520.0, 190.0, 8.0, 52.0
_GAP_SHARE: Final = 0.035  # largest width of a drawn gap / length of the bridge
_FACTORS: Final = (200, 100, 50, 20, 10, 5, 2, 1)
_JOINT_DEMANDS: Final = (("unseating_m", "unseating (mm)", 1000.0), ("closures", "closures", 1.0))


def sketch(
    bridge: Description, skews_deg: Sequence[float], gaps_mm: Sequence[float], model: ModelOptions
) -> dict[str, Any]:
    """Return the dimensions of a plan of a bridge and the corners of its parts (m).

    The decks are filled at the largest skew of the study and outlined at the other skews. Seats and
    inner joints have the gap of the bridge file or else the largest of the study, normal to the
    faces and exaggerated ``factor`` times. A seat has a gap and its keys, an integral or fixed end
    touches its wall, and a roller has no wall. Bents and columns are drawn at the largest skew.
    """
    skew = max(skews_deg, key=abs)
    gaps_m = {name: bridge.gaps_mm.get(name, max(gaps_mm)) / 1000.0 for name in bridge.seats_m}
    end_m, half_m, skews_of_ends = bridge.length_m / 2, bridge.width_m / 2, bridge.skews_deg
    largest_m, share_m = max(gaps_m.values(), default=0.0), _GAP_SHARE * bridge.length_m
    factor = next((scale for scale in _FACTORS if scale * largest_m <= share_m), 1)
    wall_m, arm_m = max(bridge.wall_m, 0.012 * bridge.length_m), 0.8 * half_m
    bent_skew = radians(model.skew_of_bents_deg(skew)) if bridge.bents_turn else 0.0
    spacing_factor = 1.0 / cos(bent_skew) if model.column_spacing == "normal" else 1.0

    def cuts(skew_deg: float) -> list[PlanVector]:
        """Return x (m) and angle (rad) of both faces of each deck at a skew, left to right."""
        faces = [(-end_m, radians(skews_of_ends.get("left", skew_deg)))]
        for number, (location, x) in enumerate(bridge.joints_m.items(), start=1):
            usual_deg = model.skew_of_bents_deg(skew_deg) if "bent" in location else skew_deg
            face_rad = radians(skews_of_ends.get(f"joint {number}", usual_deg))
            half_gap = factor * gaps_m[f"joint {number}"] / 2 / cos(face_rad)
            faces += [(x - half_gap, face_rad), (x + half_gap, face_rad)]
        return [*faces, (end_m, radians(skews_of_ends.get("right", skew_deg)))]

    def decks(faces: Sequence[PlanVector]) -> list[list[PlanVector]]:
        pairs = zip(faces[::2], faces[1::2], strict=True)
        return [_corners(face_1, face_2, (-half_m, half_m)) for face_1, face_2 in pairs]

    faces = cuts(skew)
    walls: list[list[PlanVector]] = []
    gaps = list(zip(faces[1:-1:2], faces[2:-1:2], strict=True))
    for name, (x, rad) in zip(bridge.end_kinds, (faces[0], faces[-1]), strict=True):
        kind, outward = bridge.end_kinds[name], copysign(1.0 / cos(rad), x)
        wall = x + outward * factor * (gaps_m[name] if kind == "seat" else 0.0)
        if kind != "roller":
            walls.append(_corners((wall, rad), (wall + outward * wall_m, rad), (-half_m, half_m)))
        if kind == "seat":
            key_y, inner_x = half_m + factor * model.transverse_gap_m, x - 2.2 * outward * wall_m
            for side, sign in (("+y", 1.0), ("-y", -1.0)):
                if bridge.keys_at[name] in ("both", side):
                    key_ends = sign * key_y, sign * (key_y + wall_m)
                    walls.append(_corners((inner_x, rad), (x, rad), key_ends))
            gaps.insert(0, ((x, rad), (wall, rad)))
    gap_lines = {  # lines across a gap and along its far face
        "gap": [_skewed(face, -0.5 * half_m) for pair in gaps[:1] for face in pair],
        "friction": [_skewed(far, y * half_m) for _, far in gaps[:1] for y in (0.2, 0.8)],
    }
    columns: list[list[PlanVector]] = []
    for (x_m, along_m), outline in zip(bridge.columns_m, bridge.outlines_m, strict=True):
        corners = [
            x_m + (z + 1j * (along_m * spacing_factor + y)) * rect(1, bent_skew) for y, z in outline
        ]
        columns.append([(corner.real, corner.imag) for corner in corners])
    deck_corners, end_skew_rad = decks(faces), faces[0][1]
    half_length = max(abs(x) for polygon in (*deck_corners, *walls) for x, _ in polygon)
    return {
        "width": _WIDTH,
        "height": _HEIGHT,
        "scale": min((_WIDTH / 2 - _SIDE) / half_length, (_HEIGHT / 2 - _TOP) / half_m),
        "skew": skew,
        "others": [deck for deg in sorted({*skews_deg} - {skew}) for deck in decks(cuts(deg))],
        "decks": deck_corners,
        "walls": walls,
        "marks": gap_lines if gaps else {},
        "end": end_m,
        "columns": columns,
        # a line is an area of two corners
        "bents": [
            [_skewed((x, bent_skew), y) for y in (-half_m, half_m)]
            for x in sorted({x for x, _ in bridge.columns_m})
        ],
        "ends": list(bridge.end_kinds.values()),
        "arm": arm_m,
        "tip": (-end_m - arm_m * sin(end_skew_rad), arm_m * cos(end_skew_rad)),
        "factor": factor,
    }


def _skewed(face: PlanVector, y_m: float) -> PlanVector:
    """Return the point at y on a face, given by its x on the bridge axis (m) and angle (rad)."""
    return face[0] - y_m * tan(face[1]), y_m


def _corners(left: PlanVector, right: PlanVector, y_m: PlanVector) -> list[PlanVector]:
    low, high = y_m
    return [_skewed(left, low), _skewed(right, low), _skewed(right, high), _skewed(left, high)]


def joint_rows(demands: pd.DataFrame, bridges: Sequence[Structure]) -> list[dict[str, str]]:
    """Return median and 84th percentile of unseating and closures of each inner joint."""
    rows: list[dict[str, str]] = []
    for bridge in bridges:
        runs = demands[(demands["bridge"] == bridge.name) & is_complete(demands)]
        for number, location in enumerate(bridge.description.joints_m, start=1):
            row = {"bridge": bridge.name, "joint": f"{number}, {location}"}
            for (name, heading, factor), quantile in product(_JOINT_DEMANDS, (0.5, 0.84)):
                value = factor * runs[f"joint{number}_{name}"].quantile(quantile)
                row[f"{heading}, {100 * quantile:g} %"] = f"{value:.3g}"
            rows.append(row)
    return rows


# --- curves


def curve_rows(frames: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """Return a group for each leading state: its name, and a row of curves for each axis value."""
    all_curves = with_system(frames["curves"], frames["system"])
    leading = main_curves(pooled_curves(all_curves, frames["medians"])).values()
    names = {state: state_text(records_of(fits)[0]) for state, fits in groups_of(all_curves, STATE)}
    return [
        {"state": f"{model_name(*state[:2])}: {names[state]}", "rows": records_of(rows)}
        for table in leading
        for state, rows in groups_of(table, STATE)
    ]


def with_ends(row: Mapping[str, Any], names: Sequence[str]) -> str:
    """Return an estimate with its interval, if it has one."""
    text = exports.with_interval([row[name] for name in names])
    return text.replace("--", "–").replace("inf", "∞")


# --- effects


def _effect_parts(frames: Mapping[str, pd.DataFrame]) -> dict[str, Any]:
    """Return the tables of pooled headline effects and other pooled effects, and their legend."""
    rows = pd.concat([frames["medians"], frames["effects"]], ignore_index=True)
    pooled = rows[rows["scope"] == "pooled"]
    # the only failure mode of a column, also as a ratio of shears, has the effects of any failure
    is_any = pooled["demand"] == f"{COLUMN_FAILURE}/any"
    columns = pooled[[*BRIDGE_COLUMNS, *_CHANGE, "ratio"]].fillna({"ratio": 0.0})
    effects = pd.MultiIndex.from_frame(columns)
    of_columns = pooled["demand"].str.startswith((f"{COLUMN_FAILURE}/", "column_shear/"))
    pooled = pooled[is_any | ~of_columns | ~effects.isin(effects[is_any])]
    ratios = pooled[pooled["judged_by"] == verdicts.RATIO]
    medians = pooled[pooled["quantity"] == MEDIAN_CAPACITY]
    main = pooled["demand"].isin({*HEADLINE_STATES, *demands_for("headline")})
    effects, others = (pooled[main], pooled[~main]) if main.any() else (pooled, pooled.head(0))
    return {
        "effects": verdict_table(effects, pooled),
        "other_effects": verdict_table(others, pooled),
        "any_marked": any(map(answer.extent_of_data, records_of(medians))),
        "margin": appearance.margin_text(ratios.iloc[0]) if len(ratios) else "",
        "styles": appearance.STYLES.values(),
    }


def published_rows(medians: pd.DataFrame) -> list[dict[str, str]]:
    """Return ratios of medians to skew 0 and the Hazus factor, one row per skew."""
    pooled = medians[(medians["scope"] == "pooled") & (medians["axis"] == "skew_deg")]
    pooled = pooled[pooled["demand"].isin(answer.LEADING_STATES) & (pooled["from_value"] == 0.0)]
    pooled = pooled[pooled["status"] == OK]
    pooled = pooled.assign(order=pooled["demand"].map(answer.LEADING_STATES.index))
    names, rows = answer.short_names(pooled), dict[str, dict[str, str]]()
    for effect in records_of(pooled.sort_values(["to_value", "order"])):
        skew, state = effect["to_value"], effect_name(effect["demand"])
        first = {"skew": f"{skew:g}°", "Hazus": f"{hazus_factor(skew):.2f}"}
        name = f"{names[effect['bridge'], effect['abutment']]}, {state}"
        rows.setdefault(skew, first)[name] = with_ends(effect, verdicts.RATIOS)
    return records_of(pd.DataFrame(rows.values()).fillna("–"))


def verdict_table(effects: pd.DataFrame, compared: pd.DataFrame) -> dict[str, Any]:
    """Return pooled effects: a row per demand or state, a column per model and step compared."""
    keys = [*BRIDGE_COLUMNS, *_CHANGE]
    order = [varied.name for varied in axes_of(compared["axis"])]
    headings = sorted(
        set(compared[keys].itertuples(index=False, name=None)),
        key=lambda heading: (*heading[:2], order.index(heading[2]), *heading[3:]),
    )
    rows: list[dict[str, Any]] = []
    for (demand,), demand_rows in groups_of(effects, ["demand"]):
        cells = {tuple(row[name] for name in keys): row for row in records_of(demand_rows)}
        is_state, margin = "/" in demand, appearance.margin_text(demand_rows.iloc[0])
        label = f"Median, {effect_name(demand)}" if is_state else appearance.demand_name(demand)
        ordered = [cells.get(heading) for heading in headings]
        rows.append({"label": label, "margin": margin, "cells": ordered})
    return {
        "models": Counter(model_name(*heading[:2]) for heading in headings).items(),
        "heads": [change_name(*heading[2:]) for heading in headings],
        "rows": rows,
    }


# --- figures


# The files have 300 dots per inch for print; the page has half of that.
# Lossless WebP with few shades is smaller than lossy WebP of quality 40, and its texts are sharp.
# As SVG the figures of two bridges take 10 MB; files for papers are in the folder of the figures.
_PACKING: Final[dict[str, Any]] = {"format": "webp", "lossless": True, "quality": 60, "method": 2}
_STEP: Final = 255 / 11  # between two of the twelve shades of each primary colour
_SHADES: Final = [round(round(shade / _STEP) * _STEP) for shade in range(256)]


def pictures_of(captions: Sequence[Caption], folder: Path) -> list[dict[str, Any]]:
    """Return caption, data URL and size of each figure, in the order of `SECTIONS`."""
    ordered = sorted(captions, key=lambda caption: SECTIONS.index(caption.section))
    tasks = (delayed(_packed)(folder / f"{caption.name}.png") for caption in ordered)
    data_urls: Any = Parallel(n_jobs=2, backend="threading")(tasks)
    return [{"caption": text, **picture} for text, picture in zip(ordered, data_urls, strict=True)]


def _packed(path: Path) -> dict[str, Any]:
    with Image.open(path) as image:
        picture = image.convert("RGB").reduce(2).point(_SHADES * 3)
    packed = BytesIO()
    picture.save(packed, **_PACKING)
    data = f"data:image/webp;base64,{base64.b64encode(packed.getvalue()).decode()}"
    return {"data": data, "width": picture.width, "height": picture.height}


# --- the explorer


_FIT_COLUMNS: Final = (
    *("variant", "component", "limit_state", "method", "demand", "preferred", "methods_differ"),
    *("theta", "beta_total", "threshold", "ln_a", "b", "knot", "b_above"),
    *("extrapolated", "im_low", "im_high", "curve"),
)
_CURVE_POINTS: Final = 80


def explorer_of(frames: Mapping[str, pd.DataFrame]) -> dict[str, str]:
    """Return the compressed data and library of the explorer; empty if no curve was fitted.

    The library is the basic bundle of plotly.js 4.1.1 (MIT, `vendor/LICENSE`), as published in the
    npm package plotly.js-basic-dist-min.
    """
    if not (frames["curves"]["status"] == FITTED).any():
        return {}
    library = files("skewbridge.report") / "vendor" / "plotly-basic.min.js"
    return {"data": explorer_data(frames), "library": _compressed(library.read_bytes())}


def explorer_data(frames: Mapping[str, pd.DataFrame]) -> str:
    """Return demands and curves as compressed JSON, the data of the explorer.

    A curve is a list of its probabilities and of the lower and upper ends of its band.
    """
    curves, demands = frames["curves"], with_derived_columns(frames["demands"])
    im = str(curves["im"].iloc[0])
    demand_names = [*curves["demand"].unique(), *demands_for("effect", demands.columns)]
    columns = [name for name in dict.fromkeys(demand_names) if name in demands]
    motions, variants = list(demands["motion_id"].unique()), demands.drop_duplicates("variant")
    models = variants.groupby(list(BRIDGE_COLUMNS), sort=False)
    names, axes = variants["variant"].tolist(), axes_of(demands.columns)
    values = {axis: sorted(demands[axis.name].unique()) for axis in axes}
    grid = np.geomspace(0.7 * demands[im].min(), 1.3 * demands[im].max(), _CURVE_POINTS)
    fits = curves[curves["status"] == FITTED]
    points = [np.vstack(curve_values(grid, row)).round(4).tolist() for row in records_of(fits)]
    fits = fits.assign(variant=pd.Categorical(fits["variant"], names).codes, curve=points)
    payload: dict[str, Any] = {
        "im": plain_label(im),
        "im_name": im,
        "im_values": grid,
        "colours": appearance.VARIANT_COLOURS,
        "models": [model_name(*model) for model, _ in models],
        "axes": [
            {
                "name": axis.name,
                "label": axis.label,
                "values": axis_values,
                "texts": [appearance.value_text(axis, value) for value in axis_values],
            }
            for axis, axis_values in values.items()
        ],
        "variants": [
            {
                "name": row["variant"],
                "model": number,
                "text": variant_text(shown_axes(variants), row),
                "values": [row[axis.name] for axis in axes],
            }
            for number, row in zip(models.ngroup(), records_of(variants), strict=True)
        ],
        "demands": {
            name: dict(zip(("label", "factor"), appearance.shown_label(name), strict=True))
            for name in columns
        },
        "fits": records_of(fits[list(_FIT_COLUMNS)]),
        "motions": motions,
        "statuses": STATUSES,
        "runs": {
            "variant": pd.Categorical(demands["variant"], names).codes,
            "motion": pd.Categorical(demands["motion_id"], motions).codes,
            "scale": demands["scale"],
            "status": pd.Categorical(demands["status"], STATUSES).codes,
            "complete": is_complete(demands).astype(int),
            "key": demands.get("run_key", pd.Series("", demands.index)),
            "im": demands[im],
            "demands": dict(demands[columns].items()),
        },
    }
    # NaN and infinities become null
    return _compressed(to_json(payload, inf_nan_mode="null", fallback=lambda array: array.tolist()))


def _compressed(content: bytes) -> str:
    """Return content as gzip in base64, which is a third as long as the text."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


# --- tables and quality


#: Columns whose values are names, with the function that returns them in words.
_IN_WORDS: Final = {"demand": effect_name, "im": plain_label, "abutment": in_words}


def shown_rows(
    table: pd.DataFrame | Sequence[Mapping[str, Any]], digits: int = 3
) -> list[dict[str, str]]:
    """Return the rows of a table as text, in shown units; headings are words with the unit."""
    frame = pd.DataFrame(table)
    named = {name: frame[name].map(_IN_WORDS[name]) for name in _IN_WORDS.keys() & set(frame)}
    frame = frame.assign(**named)
    texts: dict[str, list[str]] = {}
    for name in frame:
        words, unit = split_unit(str(name))
        unit, factor = appearance.shown_unit(unit, words)
        words = words.replace("rung", "recovery step").replace("_", " ")
        heading = words + ("" if unit == "-" else f" ({unit})")
        values = frame[name] if factor == 1.0 else factor * frame[name]
        texts[heading] = [number_text(value, digits) for value in values.tolist()]
    return records_of(pd.DataFrame(texts))


def number_text(value: Any, digits: int = 3) -> str:
    """Return a value of a table as text; a missing value is shown as a dash."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(str(item) for item in value)
    if pd.isna(value):
        return "–"
    return appearance.number(value, digits) if isinstance(value, float) else str(value)


def unbroken(text: str) -> str:
    """Return a text with non-breaking spaces between numbers and units."""
    return re.sub(r"(?<=\d) (?=(g|mm|in|mrad|motions)\b|%)", "\u00a0", text)


def paper_rows(curves: pd.DataFrame, medians: pd.DataFrame, joint: pd.DataFrame) -> dict[str, Any]:
    """Return headings and rows, grouped by model and state, of the table for publication."""
    table = exports.paper_table(curves, medians, joint)
    ratios = exports.ratio_names(table)
    axes = shown_axes(curves)
    names = {row["variant"]: variant_text(axes, row) for row in records_of(curves)}
    capacities = {
        state: appearance.threshold_text(rows["demand"].iloc[0], rows["threshold"].iloc[0])
        for state, rows in groups_of(curves, ["component", "limit_state"])
    }
    groups: dict[str, list[dict[str, Any]]] = {}
    for row, text in zip(records_of(table), exports.printed_rows(table), strict=True):
        capacity = capacities[row["component"], row["limit_state"]]
        model = model_name(row["bridge"], row["abutment"])
        group = groups.setdefault(f"{model}: {in_words(text['state'])} ({capacity})", [])
        variant = names.get(row["row"], "all variants, middle of the range")
        row_labels = {"variant": variant, "joint": row["row"] == exports.JOINT}
        group.append(text | row_labels | {"ratios": [text[name] for name in ratios]})
    return {
        "im": plain_label(str(curves["im"].iloc[0])),
        "level": float(curves["level"].iloc[0]),
        "ratios": [f"θ ratio, {in_words(name)}" for name in ratios],
        "groups": groups,
    }


def median_text(row: Mapping[str, Any], otherwise: str = "") -> str:
    """Return a median with its interval; without a fit, ``otherwise`` or the status in words.

    † marks an extrapolated median.
    """
    if row["status"] != FITTED:
        return otherwise or in_words(row["status"])
    text = exports.with_interval([row[f"theta{end}"] for end in ("", "_low", "_high")])
    return f"{text} {exports.DAGGER}" if row.get(exports.EXTRAPOLATED) is True else text


def quality_of(demands: pd.DataFrame, sensitivity: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers in the quality section of the page; shares are in per cent."""
    column, with_friction = "cone_work_over_10pct_ratio", demands[demands["slip_work_kj"] > 0.0]
    # after the failure of a column its fibers lose their force in jumps, which the work of end
    # forces does not follow; demands count up to the failure
    has_failed = demands[BEYOND_MODEL].fillna("").astype(bool)
    residuals, changes = demands["energy_residual_ratio"].abs(), pd.Series(dtype=float)
    if len(sensitivity):
        changes = sensitivity.set_index("demand")["reference_largest_change"].dropna()
    return {
        "residuals": 100.0 * residuals[~has_failed],
        "late": int((residuals[has_failed] > MAX_ENERGY_RESIDUAL).sum()),
        "changes": 100.0 * changes,
        "compared": sensitivity[["rows", "analysed_s"]].max() if len(sensitivity) else None,
        "excesses": 100.0 * with_friction.get(column, pd.Series(dtype=float)),
    }

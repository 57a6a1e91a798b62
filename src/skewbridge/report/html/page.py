"""The report: tables and figures of a study joined in one self-contained HTML file."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.fragility.existence import FITTED
from skewbridge.provenance.files import write_text
from skewbridge.provenance.stamp import read_stamp
from skewbridge.provenance.tables import read_frame
from skewbridge.report import answer
from skewbridge.report.choice_figures import choice_findings, choices_left_out
from skewbridge.report.html import page_tables
from skewbridge.report.html.explorer import explorer_data, library
from skewbridge.report.html.pictures import pictures_of
from skewbridge.report.methods import STATE_HEADS, methods_of
from skewbridge.report.study_figures import (
    CHOICES,
    CLOUDS,
    CURVES,
    EFFECTS,
    HISTORIES,
    MOTIONS,
    read_captions,
)
from skewbridge.report.verdict_style import LEGEND, STYLES, margin_text
from skewbridge.statuses import STATUSES
from skewbridge.study.config import parse_config

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
            intensity_effects, needed_motions, input_notes, gate, sensitivity, suite, checks,
            captions; check_predict if it was made.
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
        subtitle=page_tables.subtitle(demands, im),
        failures=answer.failure_sentence(counts),
        motions_line=answer.motions_sentence(frames["suite"], table),
        chips=page_tables.chips(demands, checks, frames["sensitivity"]),
        bridges=page_tables.bridge_lines(
            [load_bridge(name) for name in sorted(config["grid"]["bridge"])]
        ),
        cards=_cards(table, counts),
        maps=page_tables.verdict_maps(pd.concat([pooled_medians, pooled], ignore_index=True)),
        needed=page_tables.needed_sentences(frames["needed_motions"]),
        effect=_effect_words(pooled),
        styles=STYLES.values(),
        legend=LEGEND,
        paper=page_tables.paper_rows(curves, frames["medians"], frames["joint"]),
        methods_line=page_tables.methods_line(curves),
        fits=page_tables.fit_counts(curves),
        unreached=page_tables.states_not_reached(curves),
        predict_line=page_tables.predict_line(frames.get("check_predict")),
        input_notes=frames["input_notes"].to_dict("records"),
        explorer=_explorer(demands, curves, effects, frames["medians"]),
        pictures=pictures_of(read_captions(tables["captions"]), figures, _SECTIONS),
        statuses=[(status, int((demands["status"] == status).sum())) for status in STATUSES],
        recovered=int((demands["recovery_rung"] > 0).sum()),
        friction_excess=page_tables.friction_excess(demands),
        suspects=page_tables.suspect_line(demands, excluded=config["fragility"]["exclude_suspect"]),
        checks=checks,
        methods=methods_of(parse_config(config), frames["suite"]),
        state_heads=STATE_HEADS,
        sensitivity_line=page_tables.sensitivity_line(frames["sensitivity"]),
        cpu_h=float(demands["cpu_s"].sum()) / 3600.0,
        choices=[] if choices is None else _choices(read_frame(choices)),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        system=page_tables.system_rows(frames["system"]),
        measures=page_tables.measure_rows(frames["measures"]),
        measure_lines=page_tables.measure_sentences(frames["measures"], im),
        provenance=dict(sorted(read_stamp(tables["demands"]).items())),
        **{name: frames[name].to_dict("records") for name in ("gate", "sensitivity")},
    )
    write_text(output, page)


def _cards(table: pd.DataFrame, counts: pd.DataFrame) -> list[dict[str, Any]]:
    """Return a card per axis: its change, sentences for each model, and its part of the plot."""
    forest, names = page_tables.Forest(table), answer.short_names(table)
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
    """Return a text in which no line ends between a number and its unit."""
    return re.sub(r"(?<=\d) (?=(%|mm|mrad|motions)\b|%)", "\u00a0", text)


def _head(name: str) -> str:
    """Return the name of a column in words, its unit in brackets."""
    for unit, shown in (("_kn", "kN"), ("_mm", "mm"), ("_deg", "°"), ("_m", "m"), ("_s", "s")):
        if name.endswith(unit):
            return f"{name.removesuffix(unit).replace('_', ' ')} ({shown})"
    return name.replace("_", " ")

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
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.provenance.files import write_text
from skewbridge.provenance.stamp import read_stamp
from skewbridge.provenance.tables import read_frame
from skewbridge.report.choice_figures import choice_findings, choices_left_out
from skewbridge.report.figure_cases import CHOICES, CLOUDS, CURVES, EFFECTS, HISTORIES, MOTIONS
from skewbridge.report.html import statements
from skewbridge.report.html.answer import cards, model_name, title_of
from skewbridge.report.html.detail_rows import factor_rows, measure_rows, system_rows
from skewbridge.report.html.explorer import explorer_data, library
from skewbridge.report.html.paper_rows import fit_counts, paper_rows, states_out_of_reach
from skewbridge.report.html.pictures import pictures_of
from skewbridge.report.html.verdict_cells import verdict_maps
from skewbridge.report.methods import STATE_HEADS, methods_of
from skewbridge.report.study_figures import read_captions
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
            needed_motions, factors, gate, sensitivity, suite, checks, captions.
        figures: Folder of the figures.
        config: The configuration as plain values.
        output: The HTML file.
        choices: Table of modelling choices, where there is one.
    """
    frames = {name: read_frame(path) for name, path in tables.items() if path.suffix == ".parquet"}
    demands, curves, effects = (frames[name] for name in ("demands", "curves", "effects"))
    pooled = effects[effects["scope"] == "pooled"]
    checks = json.loads(tables["checks"].read_text(encoding="utf-8"))
    environment = Environment(
        loader=PackageLoader("skewbridge.report.html"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters |= {"number": _number, "head": _head, "unbroken": _unbroken}
    page = environment.get_template("report.html.j2").render(
        title=title_of(pooled),
        subtitle=statements.subtitle(demands, str(curves["im"].iloc[0])),
        chips=statements.chips(demands, checks, frames["sensitivity"]),
        bridges=statements.bridge_lines(
            [load_bridge(name) for name in sorted(config["grid"]["bridge"])]
        ),
        cards=cards(pooled, frames["needed_motions"]),
        maps=verdict_maps(pooled),
        effect=_effect_words(pooled),
        styles=STYLES.values(),
        legend=LEGEND,
        paper=paper_rows(curves, frames["medians"], frames["joint"]),
        fits=fit_counts(curves),
        unreached=states_out_of_reach(curves),
        explorer=_explorer(demands, curves, effects),
        pictures=pictures_of(read_captions(tables["captions"]), figures, _SECTIONS),
        statuses=[(status, int((demands["status"] == status).sum())) for status in STATUSES],
        recovered=int((demands["recovery_rung"] > 0).sum()),
        beyond_model=statements.beyond_model(demands),
        friction_excess=statements.friction_excess(demands),
        suspects=statements.suspect_line(demands, excluded=config["fragility"]["exclude_suspect"]),
        checks=checks,
        methods=methods_of(parse_config(config), frames["suite"]),
        state_heads=STATE_HEADS,
        sensitivity_line=statements.sensitivity_line(frames["sensitivity"]),
        cpu_h=float(demands["cpu_s"].sum()) / 3600.0,
        choices=[] if choices is None else _choices(read_frame(choices)),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        system=system_rows(frames["system"]),
        measures=measure_rows(frames["measures"]),
        factors=factor_rows(frames["factors"]),
        provenance=dict(sorted(read_stamp(tables["demands"]).items())),
        **{name: frames[name].to_dict("records") for name in ("gate", "sensitivity")},
    )
    write_text(output, page)


def _explorer(demands: pd.DataFrame, curves: pd.DataFrame, effects: pd.DataFrame) -> dict[str, str]:
    """Return what the explorer needs; empty without a curve."""
    if not (curves["status"] == FITTED).any():
        return {}
    return {"data": explorer_data(demands, curves, effects), "library": library()}


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
            "model": model_name(bridge, abutment),
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

"""The report: tables and figures of a study joined in one self-contained HTML file."""

import base64
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import pandas as pd
import pyarrow.parquet as pq
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.demands.columns import label_of
from skewbridge.fragility.tables.beyond_model import KINDS, failure_kinds
from skewbridge.fragility.tables.effects import MATTERS, NEGLIGIBLE, UNDECIDED
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.choice_figures import choice_findings, choices_left_out
from skewbridge.report.study_figures import read_captions
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import axes_of

ESTIMATES: Final = tuple(f"{of}{end}" for of in ("theta", "beta") for end in ("", "_low", "_high"))
COUNTS: Final = ("n_runs", "n_exceed", "n_collapse", "n_beyond_model", "n_unknown")
CURVE_NAMES: Final = ("variant", "component", "limit_state", "method", "status")
CURVE_COLUMNS: Final = [*CURVE_NAMES, *ESTIMATES, *COUNTS, "theta_bound", "warnings"]
EFFECT_COUNTS: Final = ("n_motions", "n_left_out", "n_beyond_model")
EFFECT_RESULTS: Final = ("ratio", "ci_low", "ci_high", *EFFECT_COUNTS, "verdict")
JOINT_NAMES: Final = ("bridge", "abutment", "component", "limit_state", "source")
JOINT_ERRORS: Final = ("loo_error", "loo_error_max", "loo_error_max_se", "loo_variants")
JOINT_COLUMNS: Final = [*JOINT_NAMES, *ESTIMATES, "beta_total", *JOINT_ERRORS, "terms"]
WHOLE: Final = ("factors", "system", "gate", "sensitivity")
VERDICTS: Final = (NEGLIGIBLE, MATTERS, UNDECIDED)


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
        tables: Paths by name: demands, curves, medians, system, joint, effects, factors, gate,
            sensitivity, checks, captions.
        figures: Folder of the figures.
        config: The configuration as plain values.
        output: The HTML file.
        choices: Table of modelling choices, where there is one.
    """
    demands = read_frame(tables["demands"])
    curves = read_frame(tables["curves"])
    effects = read_frame(tables["effects"])
    effects = effects[effects["scope"] == "variant"]
    medians = read_frame(tables["medians"])
    joint = read_frame(tables["joint"])
    missed = curves.loc[curves["status"] == "no_exceedance", "limit_state"]
    captions = read_captions(tables["captions"])
    drawn = [base64.b64encode((figures / f"{c.name}.svg").read_bytes()).decode() for c in captions]
    checks = json.loads(tables["checks"].read_text(encoding="utf-8"))
    environment = Environment(
        loader=PackageLoader("skewbridge.report.html"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["number"] = _number
    page = environment.get_template("report.html.j2").render(
        bridges=[load_bridge(name) for name in sorted(config["grid"]["bridge"])],
        statuses=[(status, int((demands["status"] == status).sum())) for status in STATUSES],
        beyond_model=_beyond_model(demands),
        summary=_summary(demands),
        headline=_headline(effects),
        margin=float(effects["margin"].iloc[0]) if len(effects) else 0.0,
        verdicts=VERDICTS,
        checks=checks,
        excludes_suspect=config["fragility"]["exclude_suspect"],
        captions=list(zip(captions, drawn, strict=True)),
        curves=curves[CURVE_COLUMNS].to_dict("records"),
        effects=effects[_effect_columns(effects)].to_dict("records"),
        joint=joint.loc[joint["preferred"], JOINT_COLUMNS].to_dict("records"),
        medians=medians[_effect_columns(medians)].to_dict("records"),
        **{name: read_frame(tables[name]).to_dict("records") for name in WHOLE},
        choices=[] if choices is None else _choices(read_frame(choices)),
        no_exceedance=sorted(set(missed)),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        provenance=_provenance(tables["demands"]),
    )
    write_text(output, page)


def _beyond_model(demands: pd.DataFrame) -> str:
    kinds = failure_kinds(demands)
    counts = [f"{name} {int((kinds == name).sum())}" for name in KINDS]
    return ", ".join(counts)


def _summary(demands: pd.DataFrame) -> dict[str, Any]:
    return {
        "analyses": len(demands),
        "variants": demands["variant"].nunique(),
        "motions": demands["motion_id"].nunique(),
        "cpu_h": demands["cpu_s"].sum() / 3600,
        "recovered": int((demands["recovery_rung"] > 0).sum()),
        "cone": demands["cone_violation_ratio"].max(),
        "energy": demands["energy_residual_ratio"].abs().median(),
    }


def _effect_columns(table: pd.DataFrame) -> list[str]:
    axes = [axis.name for axis in axes_of(table.columns)]
    return ["bridge", "axis", "from_value", "to_value", *axes, "demand", *EFFECT_RESULTS]


def _headline(effects: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the range of the effect of friction on every demand, and how often each verdict."""
    friction = effects[effects["axis"] == "friction"]
    return [
        {
            "bridge": bridge,
            "demand": label_of(str(demand)),
            "low": group["ratio"].min(),
            "high": group["ratio"].max(),
            "level": group["level"].iloc[0],
            "verdicts": [int((group["verdict"] == verdict).sum()) for verdict in VERDICTS],
        }
        for (bridge, demand), group in friction.groupby(["bridge", "demand"], sort=False)
    ]


def _choices(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the findings and the rows of every bridge and abutment model."""
    return [
        {
            "model": f"{bridge}, {str(abutment).replace('_', '-')}",
            "findings": choice_findings(own),
            "left_out": choices_left_out(own),
            "pairs": int(own["n_pairs"].max()),
            "rows": own.drop(columns=["bridge", "abutment"]).to_dict("records"),
        }
        for (bridge, abutment), own in table.groupby(["bridge", "abutment"], sort=False)
    ]


def _provenance(path: Path) -> dict[str, str]:
    metadata = pq.read_schema(path).metadata or {}
    return {
        key.decode(): value.decode()
        for key, value in sorted(metadata.items())
        if key not in {b"pandas", b"ARROW:schema"}
    }


def _number(value: object, digits: int = 3) -> str:
    if value is None or value is pd.NA or value != value:
        return "–"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(str(item) for item in value)
    return str(value)

"""The report: tables and figures of a study joined in one self-contained HTML file."""

import base64
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import pandas as pd
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.fragility.tables.beyond_model import KINDS, failure_kinds
from skewbridge.provenance.files import write_text
from skewbridge.provenance.stamp import read_stamp
from skewbridge.provenance.tables import read_frame
from skewbridge.report.choice_figures import choice_findings, choices_left_out
from skewbridge.report.html.effect_rows import headline_rows, verdict_shares
from skewbridge.report.study_figures import read_captions
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import axes_of

ESTIMATES: Final = tuple(f"{of}{end}" for of in ("theta", "beta") for end in ("", "_low", "_high"))
COUNTS: Final = ("n_runs", "n_exceed", "n_collapse", "n_beyond_model", "n_unknown")
CURVE_NAMES: Final = ("variant", "component", "limit_state", "method", "status")
BOUNDS: Final = tuple(
    f"theta_{kind}_{end}" for kind in ("bracket", "bound") for end in ("low", "high")
)
CURVE_COLUMNS: Final = [*CURVE_NAMES, *ESTIMATES, *COUNTS, *BOUNDS, "warnings"]
EFFECT_COUNTS: Final = ("n_motions", "n_bounds", "n_left_out", "n_beyond_model")
RATIOS: Final = ("ratio", "ci_low", "ci_high")
DIFFERENCES: Final = ("difference", "difference_low", "difference_high", "unit")
JUDGED: Final = ("verdict", "direction", "verdict_family")
POOLED_RESULTS: Final = (*RATIOS, *DIFFERENCES, *JUDGED, "p_cells", *EFFECT_COUNTS)
EFFECT_RESULTS: Final = (*RATIOS, "shrunk_ratio", *DIFFERENCES, *JUDGED, *EFFECT_COUNTS)
MEDIAN_RESULTS: Final = (*RATIOS, *JUDGED, *EFFECT_COUNTS)
JOINT_NAMES: Final = ("bridge", "abutment", "component", "limit_state", "source")
JOINT_ERRORS: Final = ("loo_error", "loo_error_max", "loo_error_max_se", "loo_variants")
JOINT_COLUMNS: Final = [*JOINT_NAMES, *ESTIMATES, "beta_total", *JOINT_ERRORS, "terms"]
WHOLE: Final = ("factors", "system", "measures", "gate", "sensitivity")


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
            needed_motions, factors, gate, sensitivity, checks, captions.
        figures: Folder of the figures.
        config: The configuration as plain values.
        output: The HTML file.
        choices: Table of modelling choices, where there is one.
    """
    demands = read_frame(tables["demands"])
    curves = read_frame(tables["curves"])
    effects = read_frame(tables["effects"])
    pooled, cells = (effects[effects["scope"] == scope] for scope in ("pooled", "variant"))
    needed = read_frame(tables["needed_motions"])
    medians = read_frame(tables["medians"])
    joint = read_frame(tables["joint"])
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
        headline=headline_rows(pooled, needed),
        level=float(effects["level"].iloc[0]) if len(effects) else 0.0,
        shares=verdict_shares(cells),
        checks=checks,
        excludes_suspect=config["fragility"]["exclude_suspect"],
        captions=list(zip(captions, drawn, strict=True)),
        curves=curves[CURVE_COLUMNS].to_dict("records"),
        pooled=pooled[_effect_columns(pooled, POOLED_RESULTS)].to_dict("records"),
        effects=cells[_effect_columns(cells, EFFECT_RESULTS)].to_dict("records"),
        joint=joint.loc[joint["preferred"], JOINT_COLUMNS].to_dict("records"),
        medians=medians[_effect_columns(medians, MEDIAN_RESULTS)].to_dict("records"),
        needed=needed.to_dict("records"),
        **{name: read_frame(tables[name]).to_dict("records") for name in WHOLE},
        choices=[] if choices is None else _choices(read_frame(choices)),
        unreached=_unreached(curves),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        provenance=dict(sorted(read_stamp(tables["demands"]).items())),
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


def _unreached(curves: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the states that no run of some variant reached, with what limits their demand."""
    told = curves[(curves["reach"] != "") & (curves["method"] == "cloud")]
    variants = curves["variant"].nunique()
    return [
        {
            "state": f"{component}, {state}".replace("_", " "),
            "variants": f"{len(own)} of {variants}",
            "reason": own["reach"].iloc[0],
        }
        for (component, state, _), own in told.groupby(
            ["component", "limit_state", "mechanism"], sort=False
        )
    ]


def _effect_columns(table: pd.DataFrame, results: Sequence[str]) -> list[str]:
    pooled = bool((table["scope"] == "pooled").all())
    axes = [] if pooled else [axis.name for axis in axes_of(table.columns)]
    return ["bridge", "abutment", "axis", "from_value", "to_value", *axes, "demand", *results]


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


def _number(value: object, digits: int = 3) -> str:
    if value is None or value is pd.NA or value != value:
        return "–"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(str(item) for item in value)
    return str(value)

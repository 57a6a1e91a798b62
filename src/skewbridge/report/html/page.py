"""The report: tables and figures of a study joined in one self-contained HTML file."""

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd
import pyarrow.parquet as pq
import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame
from skewbridge.report.study_figures import Caption, read_captions

CURVE_COLUMNS: Final = (
    "variant",
    "component",
    "limit_state",
    "method",
    "status",
    "theta",
    "theta_low",
    "theta_high",
    "beta",
    "beta_low",
    "beta_high",
    "n_runs",
    "n_exceed",
    "n_collapse",
    "n_unknown",
    "theta_bound",
    "warnings",
)
EFFECT_COLUMNS: Final = (
    "bridge",
    "axis",
    "from_value",
    "to_value",
    "skew_deg",
    "gap_mm",
    "friction",
    "demand",
    "ratio",
    "ci_low",
    "ci_high",
    "n_motions",
    "n_left_out",
    "verdict",
)
STATUS_ORDER: Final = ("ok", "collapse", "numerical_failure", "timeout", "crash", "invalid_input")


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure in the page.

    Attributes:
        caption: Title and text.
        data: The SVG as base64.
    """

    caption: Caption
    data: str


def write_report(*, tables: Mapping[str, Path], config: Mapping[str, Any], output: Path) -> None:
    """Write the report.

    Args:
        tables: Paths by name: demands, curves, medians, system, effects, factors, gate,
            sensitivity, checks, figures.
        config: The configuration as plain values.
        output: The HTML file.
    """
    demands = read_frame(tables["demands"])
    curves = read_frame(tables["curves"])
    effects = read_frame(tables["effects"])
    medians = read_frame(tables["medians"])
    checks = json.loads(tables["checks"].read_text(encoding="utf-8"))
    environment = Environment(
        loader=PackageLoader("skewbridge.report.html"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["number"] = _number
    page = environment.get_template("report.html.j2").render(
        bridges=[_bridge_row(name) for name in sorted(demands["bridge"].unique())],
        statuses=_statuses(demands),
        summary=_summary(demands),
        headline=_headline(effects),
        checks=checks,
        pictures=_pictures(tables["figures"]),
        curves=_records(curves[[*CURVE_COLUMNS]]),
        effects=_records(effects.loc[effects["scope"] == "variant", [*EFFECT_COLUMNS]]),
        factors=_records(read_frame(tables["factors"])),
        medians=_records(medians[[*EFFECT_COLUMNS]]),
        system=_records(read_frame(tables["system"])),
        gate=_records(read_frame(tables["gate"])),
        sensitivity=_records(read_frame(tables["sensitivity"])),
        no_exceedance=_no_exceedance(curves),
        config=yaml.safe_dump(dict(config), sort_keys=False),
        provenance=_provenance(tables["demands"]),
    )
    write_text(output, page)


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


def _statuses(demands: pd.DataFrame) -> list[tuple[str, int]]:
    counts = demands["status"].value_counts()
    return [(status, int(counts.get(status, 0))) for status in STATUS_ORDER]


def _headline(effects: pd.DataFrame) -> list[dict[str, Any]]:
    friction = effects[(effects["axis"] == "friction") & (effects["scope"] == "variant")]
    rows = []
    for (bridge, demand), group in friction.groupby(["bridge", "demand"], sort=False):
        verdicts = group["verdict"].value_counts()
        rows.append(
            {
                "bridge": bridge,
                "demand": demand,
                "low": group["ratio"].min(),
                "high": group["ratio"].max(),
                **{
                    name: int(verdicts.get(name, 0))
                    for name in ("negligible", "matters", "undecided")
                },
            }
        )
    return rows


def _no_exceedance(curves: pd.DataFrame) -> list[str]:
    states = curves.loc[curves["status"] == "no_exceedance", "limit_state"]
    return sorted({str(state) for state in states})


def _bridge_row(name: str) -> dict[str, Any]:
    data = load_bridge(name)
    return {
        "name": name,
        "title": data.title,
        "base": data.base,
        "t1_s": data.t1_s,
        "is_surrogate": data.details == "surrogate",
    }


def _pictures(folder: Path) -> list[Picture]:
    return [
        Picture(
            caption=caption,
            data=base64.b64encode((folder / f"{caption.name}.svg").read_bytes()).decode(),
        )
        for caption in read_captions(folder)
    ]


def _provenance(path: Path) -> dict[str, str]:
    metadata = pq.read_schema(path).metadata or {}
    return {
        key.decode(): value.decode()
        for key, value in sorted(metadata.items())
        if key not in {b"pandas", b"ARROW:schema"}
    }


def _records(frame: pd.DataFrame) -> Sequence[Mapping[str, Any]]:
    return [dict(zip(frame.columns, row, strict=True)) for row in frame.itertuples(index=False)]


def _number(value: object, digits: int = 3) -> str:
    if value is None or value is pd.NA or value != value:
        return "–"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(str(item) for item in value)
    return str(value)

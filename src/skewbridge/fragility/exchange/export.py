"""Fragility curves for other tools: OpenQuake NRML, pelicun CSV, plain CSV.

References:
    OpenQuake engine manual, fragility models (NRML 0.5, format ``continuous``, shape ``logncdf``;
    its mean and stddev are those of the lognormal variable, not of its logarithm).
    Pelicun fragility database format (``LS1-Family``, ``LS1-Theta_0``, ``LS1-Theta_1``).
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_table, write_csv
from skewbridge.fragility.exchange.risk import annual_frequency
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.tables.key_columns import need_columns, variant_columns

FORMATS: Final = ("nrml", "pelicun", "csv")
_NRML: Final = "http://openquake.org/xmlns/nrml/0.5"
_CMPS_PER_MPS: Final = 100.0  # OpenQuake takes PGV in cm/s
_KEY_COLUMNS: Final = ("variant", "component", "limit_state", "method")
_CURVE_COLUMNS: Final = (
    "component", "limit_state", "method", "im", "theta", "beta", "beta_total", "theta_low",
    "theta_high", "beta_low", "beta_high", "ci_method", "level", "status", "warnings", "n_runs",
    "n_records", "n_unknown",
)  # fmt: skip


def export_curves(
    source: Path, form: str, out: Path, *, method: str = "cloud", hazard: Path | None = None
) -> dict[str, Any]:
    """Write the curves of a study for another tool.

    Curves without an estimate are left out (a number would have to be invented); they are counted
    in the answer. The dispersion written is the total one, with the capacity's, where it exists.

    Args:
        source: results/fragility/curves.parquet, or the same as CSV.
        form: nrml, pelicun or csv.
        out: File to write.
        method: cloud, exceedance or ida_interval.
        hazard: CSV with columns im and rate (per year) in the measure of the curves: the csv
            format then has the mean annual frequency of every limit state.

    Returns:
        ``file``, ``format``, ``curves`` (written) and ``left_out``.

    Raises:
        InputError: The format is unknown, the table unreadable or empty, or an intensity measure
            has no name in the other tool.
    """
    if form not in FORMATS:
        raise InputError(f"format must be one of {', '.join(FORMATS)}, got {form!r}")
    table = read_table(source)
    need_columns(table, (*_KEY_COLUMNS, "status", "theta", "beta"), source.name)
    chosen = table[table["method"] == method]
    if chosen.empty:
        known = ", ".join(sorted(table["method"].unique()))
        raise InputError(f"no curves of method {method!r} (known: {known})")
    usable = chosen[chosen["status"] == FITTED]
    total = usable["beta_total"].where(usable["beta_total"].notna(), usable["beta"])
    usable = usable.assign(beta_written=total)
    try:
        if form == "csv":
            plain = chosen[[c for c in (*variant_columns(chosen), *_CURVE_COLUMNS) if c in chosen]]
            if hazard is not None:
                plain = plain.assign(**_frequencies(usable, hazard))
            write_csv(plain, out)
            written = len(chosen)
        elif form == "pelicun":
            written = _write_pelicun(usable, out)
        else:
            written = _write_nrml(usable, out, method)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error}") from error
    left_out = len(chosen) - written
    return {"file": str(out), "format": form, "curves": written, "left_out": left_out}


def openquake_measure(column: str) -> tuple[str, float]:
    """Return the OpenQuake name of an intensity column and the factor to its unit.

    Raises:
        InputError: OpenQuake has no such measure.
    """
    named = {"im_pga": ("PGA", 1.0), "im_pgv": ("PGV", _CMPS_PER_MPS), "im_saavg": ("AvgSA", 1.0)}
    advice = "name in OpenQuake: fit with im_sa_1p000_rotd50_g or another Sa(T)"
    return _named(column, ("SA({period_s})", 1.0), named, advice)


def _pelicun_demand(column: str) -> tuple[str, str]:
    """Return the demand type of an intensity column and its unit in pelicun."""
    named = {
        "im_pga": ("Peak Ground Acceleration", "g"),
        "im_pgv": ("Peak Ground Velocity", "mps"),
        "im_saavg": ("Spectral Acceleration|Avg", "g"),
        "im_sa_t1": ("Spectral Acceleration|T1", "g"),
    }
    spectral = ("Spectral Acceleration|{period_s}", "g")
    return _named(column, spectral, named, "demand type in pelicun")


def _named[Unit](
    column: str, spectral: tuple[str, Unit], named: Mapping[str, tuple[str, Unit]], what: str
) -> tuple[str, Unit]:
    """Return name and unit of an intensity column: a spectral acceleration, else by its start."""
    match = re.match(r"im_sa_(\d+)p(\d+)_", column)
    if match:
        return spectral[0].format(period_s=f"{float(f'{match[1]}.{match[2]}'):g}"), spectral[1]
    for start, found in named.items():
        if column.startswith(start):
            return found
    raise InputError(f"{column} has no {what}", column=column)


def _frequencies(usable: pd.DataFrame, hazard: Path) -> dict[str, pd.Series]:
    """Return annual frequency and probability in 50 years of the curves that have an estimate.

    Both are of the range of the hazard table; beside them stand what the intensities above its last
    level add at least and at most, and the probability at its first, below which nothing counts.
    """
    table = read_table(hazard)
    need_columns(table, ("im", "rate"), hazard.name)
    measures = usable["im"].unique()
    if len(measures) > 1:
        raise InputError(f"one hazard table cannot serve the measures {', '.join(measures)}")
    found = [
        annual_frequency(theta, beta, table["im"].to_numpy(), table["rate"].to_numpy())
        for theta, beta in zip(usable["theta"], usable["beta_written"], strict=True)
    ]
    values = {
        "annual_frequency": [item.frequency for item in found],
        "probability_50y": [item.probability_50y for item in found],
        "annual_frequency_above_least": [item.above_least for item in found],
        "annual_frequency_above_most": [item.above for item in found],
        "probability_at_first_level": [item.below for item in found],
    }
    return {name: pd.Series(column, index=usable.index) for name, column in values.items()}


def _write_nrml(table: pd.DataFrame, out: Path, method: str) -> int:
    """Write one function per variant and component; its states must be those of the model.

    NRML has one list of limit states per model, so the states are named component.state, and a
    function that lacks one of its component's states cannot be written: components are
    separate models when their states differ.
    """
    states = {
        str(name): list(dict.fromkeys(part["limit_state"]))
        for name, part in table.groupby("component", sort=False)
    }
    files = {out: list(states)}
    if len({tuple(value) for value in states.values()}) > 1:
        files = {_beside(out, name): [name] for name in states}
    written = 0
    for path, components in files.items():
        part = table[table["component"].isin(components)]
        wanted = states[components[0]] if components else []
        written += _write_nrml_file(part, wanted, path, method)
    return written


def _beside(out: Path, component: str) -> Path:
    """Return the file of one component, in the folder of the file asked for."""
    return out.with_name(f"{out.stem}_{re.sub(r'[^A-Za-z0-9_-]+', '_', component)}{out.suffix}")


def _write_nrml_file(table: pd.DataFrame, states: list[str], path: Path, method: str) -> int:
    ElementTree.register_namespace("", _NRML)
    root = ElementTree.Element(f"{{{_NRML}}}nrml")

    def add(parent: Element, tag: str, text: str = "", **values: str) -> Element:
        element = ElementTree.SubElement(parent, f"{{{_NRML}}}{tag}", values)
        element.text = text or None
        return element

    model = add(
        root,
        "fragilityModel",
        id="skewbridge",
        assetCategory="bridges",
        lossCategory="structural",
    )
    text = f"skewbridge, {method} fits, lognormal; dispersion with that of the capacity"
    add(model, "description", text)
    add(model, "limitStates", " ".join(states))
    written = 0
    for (variant, component), part in table.groupby(["variant", "component"], sort=True):
        rows = {str(item["limit_state"]): item for item in part.to_dict("records")}
        if set(rows) != set(states):
            continue
        measure, factor = openquake_measure(str(part["im"].iloc[0]))
        name = f"{variant}.{component}"
        function = add(model, "fragilityFunction", id=name, format="continuous", shape="logncdf")
        middle = part["theta"].to_numpy(dtype=np.float64) * factor
        reach = np.exp(4.0 * part["beta_written"].max())
        low, high = f"{middle.min() / reach:.6g}", f"{middle.max() * reach:.6g}"
        add(function, "imls", imt=measure, noDamageLimit=low, minIML=low, maxIML=high)
        for state in states:
            theta, beta = float(rows[state]["theta"]) * factor, float(rows[state]["beta_written"])
            mean = theta * np.exp(0.5 * beta**2)
            deviation = mean * np.sqrt(np.expm1(beta**2))
            add(function, "params", ls=state, mean=f"{mean:.10g}", stddev=f"{deviation:.10g}")
            written += 1
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)
    return written


def _write_pelicun(table: pd.DataFrame, out: Path) -> int:
    rows: list[dict[str, Any]] = []
    deepest = 0
    for (variant, component), part in table.groupby(["variant", "component"], sort=True):
        ordered = part.sort_values("threshold")
        deepest = max(deepest, len(ordered))
        demand, unit = _pelicun_demand(str(part["im"].iloc[0]))
        row: dict[str, Any] = {
            "ID": f"{variant}.{component}",
            "Incomplete": 0,
            "Demand-Type": demand,
            "Demand-Unit": unit,
            "Demand-Offset": 0,
            "Demand-Directional": 0,
        }
        for number, item in enumerate(ordered.to_dict("records"), start=1):
            row |= {
                f"LS{number}-Family": "lognormal",
                f"LS{number}-Theta_0": item["theta"],
                f"LS{number}-Theta_1": item["beta_written"],
                f"LS{number}-DamageStateWeights": "",
            }
        rows.append(row)
    write_csv(pd.DataFrame(rows), out)
    return len(table)

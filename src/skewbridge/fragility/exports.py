"""Export fragility curves to OpenQuake (NRML), pelicun and its library, CSV and LaTeX.

Sources: OpenQuake engine manual (NRML 0.5, shape ``logncdf``: mean and stddev of the lognormal
variable, not of its logarithm); pelicun 3, fragility database; Damage and Loss Model Library (DLML)
of the SimCenter.
"""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.digests import digest_of
from skewbridge.files.tables import (
    Floats,
    read_any,
    records_of,
    write_csv,
)
from skewbridge.files.text import write_text
from skewbridge.fragility.curves import METHODS
from skewbridge.fragility.demand_table import axis_names, described, need_columns, variant_columns
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.hazard import site_hazard
from skewbridge.fragility.limit_states import hazus_factor
from skewbridge.fragility.paper_table import chosen_curves, latex_table, paper_table, with_ratios
from skewbridge.fragility.rates import rates_of_curves, with_bounds
from skewbridge.fragility.union import UNION_COLUMNS, Union, curve_probability, union_curve

_NEEDED: Final = (
    "variant", "component", "limit_state", "demand", "threshold", "method", "status", "im", "theta",
    "beta", "beta_total",
)  # fmt: skip
#: Columns of a CSV of curves, described in `CURVE_COLUMNS`.
PARAMETERS: Final = (
    "component", "limit_state", "method", "im", "theta", "theta_low", "theta_high", "beta_total",
    "beta_total_low", "beta_total_high", "beta", "beta_low", "beta_high", "ci_method", "level",
    "status", "warnings", "methods_ratio", "methods_differ", "n_exceed", "n_runs", "n_records",
    "n_unknown", "extrapolated", *UNION_COLUMNS,
)  # fmt: skip
#: Last columns of a CSV of skew factors: factor = theta / theta_straight (median at skew 0). The
#: interval is paired (same motions at both skews, from median_effects.parquet next to the curves)
#: or independent (from the variances of both medians; 90 %, wider).
SKEW_FACTOR_COLUMNS: Final = (
    "skew_deg", "im", "theta", "theta_straight", "factor", "factor_low", "factor_high", "interval",
    "hazus_factor", "extrapolated",
)  # fmt: skip
_NRML: Final = "http://openquake.org/xmlns/nrml/0.5"
#: First letters of an intensity column: name and factor in OpenQuake, demand and unit in pelicun.
_MEASURES: Final = {
    "im_pga": ("PGA", 1.0, "Peak Ground Acceleration", "g"),
    "im_pgv": ("PGV", 100.0, "Peak Ground Velocity", "mps"),
    "im_saavg": ("AvgSA", 1.0, "Spectral Acceleration|Avg", "g"),
    "im_sa_t1": ("", 1.0, "Spectral Acceleration|T1", "g"),
}
#: Accepted characters and length of names; pelicun splits names at ``-`` and then finds no row.
_PELICUN_ID: Final = ("A-Za-z0-9_.", 200)
_PELICUN_PARAMETERS: Final = ("Family", "Theta_0", "Theta_1", "DamageStateWeights")
_ABSENT: Final = pd.Series(dtype=np.bool_)  # replaces a missing column
_LEVELS: Final = 800  # of a curve that is a union; linear interpolation errs by less than 5e-5


@dataclass(frozen=True, slots=True, kw_only=True)
class Export:
    """Curves to export, and the options of the formats."""

    source: Path  # table of curves
    out: Path
    method: str | None = None  # method of the curves; None: preferred curves
    hazard: Path | None = None  # hazard curve: a csv also has the columns of `rates`
    im_range: tuple[float, float] | None = None  # csv: 50 probabilities between these intensities
    skew_factors: bool = False  # csv: `SKEW_FACTOR_COLUMNS`; pelicun: scaling of capacities

    def check(self, form: str) -> None:
        """Raise an `InputError` if the format or the combination of options is not possible."""
        if form not in WRITERS:
            raise InputError(f"format must be one of {', '.join(WRITERS)}, got {form!r}")
        contents = [self.hazard is not None, self.im_range is not None]
        contents.append(self.skew_factors and form != "pelicun")
        if form != "csv" and any(contents):
            rule = "--im-range and --hazard need --format csv; --skew-factors needs csv or pelicun"
            raise InputError(f"{form} contains curve parameters only: {rule}")
        if sum(contents) > 1:
            one = "use one of --hazard, --im-range and --skew-factors"
            raise InputError(f"a csv has one table: {one}")
        low, high = self.im_range or (1.0, 2.0)
        if not 0.0 < low < high < float("inf"):
            raise InputError(f"--im-range needs 0 < low < high, got {low:g} to {high:g}")

    def table(self, name: str) -> pd.DataFrame:
        """Return a table from the folder of the curves, or an empty one without its file."""
        path = self.source.parent / f"{name}.parquet"
        return read_any(path) if path.is_file() else pd.DataFrame(columns=list(described(name)))


def export_curves(source: Path, form: str, out: Path, **options: Any) -> dict[str, Any]:
    """Write the curves of a study for another tool or a paper, and return a report.

    ``options`` are those of `Export`. Curves without an estimate are listed with their status in a
    CSV and omitted in other formats. The report lists them in ``unfitted``. It has the entry
    ``models`` for nrml, and ``holes`` for pelicun and dlml. For dlml, ``out`` is a folder. An
    `InputError` names an unusable format, option, table or intensity measure.
    """
    export = Export(source=source, out=out, **options)
    export.check(form)
    table = read_any(source)
    need_columns(table, _NEEDED, "the table of curves")
    curves = exported_curves(with_bounds(table), export.method)
    has_estimate = curves["status"] == FITTED
    if not has_estimate.any() and form != "csv":
        raise InputError(f"{source.name}: nothing to write, because no curve has an estimate")
    unfitted = curves.loc[~has_estimate, ["variant", "component", "limit_state", "status"]]
    notes = ["beta_total is exported: record-to-record and capacity dispersion"]
    if lacking := int(curves.loc[has_estimate, "beta_total"].isna().sum()):
        notes.append(f"{lacking} curves have no beta_total (no slope): beta is exported instead")
    if len(unfitted):
        notes.append(f"{len(unfitted)} limit states have no estimate (listed by --json)")
    if outside := int(curves.get("extrapolated", _ABSENT).eq(other=True).sum()):
        text = "fewer than three motions are as strong, or as weak"
        notes.append(f"{outside} medians are extrapolated: {text}")
    report = {"format": form, "files": [str(out)], "left_out": len(unfitted)}
    report |= {"curves": int(has_estimate.sum())}
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        written = WRITERS[form](curves, export)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error}") from error
    notes += written.pop("notes", [])
    return report | written | {"notes": notes, "unfitted": unfitted.astype(str).to_dict("records")}


def _write_latex(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    table = paper_table(curves, export.table("median_effects"), export.table("joint"))
    write_text(export.out, latex_table(table))
    return {}


def _write_csv(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    """Write probabilities, skew factors or parameters of curves, these with rates if asked."""
    notes: list[str] = []
    if export.im_range is not None:
        table = _probabilities(curves, np.geomspace(*export.im_range, 50))
    elif export.skew_factors:
        factors = _skew_factors(curves, export.table("median_effects"))
        table = factors.drop(columns="variant_straight")
    else:
        names = (*variant_columns(curves), *PARAMETERS)
        table = curves[[name for name in names if name in curves]]
        measures = list(map(str, curves["im"].dropna().unique()))
        if export.hazard is not None and len(measures) != 1:
            text = f"the curves use {', '.join(measures) or 'none'}"
            raise InputError(f"a hazard curve is for one intensity measure; {text}")
        if (site := site_hazard(export.hazard, "".join(measures))) is not None:
            rates = rates_of_curves(curves, export.table("joint"), site)
            table = table.join(rates[[name for name in rates if name not in table]])
            share = rates["share_outside_high"].max()
            text = f"those above add at most {share:.1%} to one of the rates"
            notes.append(f"rates include only the intensities in {site.source}; {text}")
    write_csv(table, export.out)
    return {"notes": notes}


def exported_curves(table: pd.DataFrame, method: str | None = None) -> pd.DataFrame:
    """Return the curve of ``method``, or the preferred curve, per variant and limit state.

    The column ``curve_beta`` is beta_total, or beta if there is no slope to convert the dispersion
    of the capacity. ``damage_scale`` is the component, or component and state if the states of the
    component have different demands.
    """
    if method is not None and method not in METHODS:
        raise InputError(f"method must be one of {', '.join(METHODS)}, got {method!r}")
    need_columns(table, _NEEDED if method else (*_NEEDED, "preferred"), "the table of curves")
    rows = chosen_curves(table, method).reset_index(drop=True)
    if rows.empty:
        known = ", ".join(sorted(table["method"].unique()))
        raise InputError(f"no curves of method {method!r}; the table has {known}")
    scale, state = rows["component"].astype(str), rows["limit_state"].astype(str)
    single = rows.groupby("component")["demand"].transform("nunique") == 1
    beta = rows["beta_total"].fillna(rows["beta"])
    return rows.assign(curve_beta=beta, damage_scale=scale.where(single, scale + "_" + state))


def _functions(curves: pd.DataFrame) -> Iterator[tuple[str, str, list[str], pd.DataFrame]]:
    """Yield variant, damage scale, states sorted by threshold, and curves indexed by state."""
    ordered = curves.sort_values("threshold", kind="stable")
    states = ordered.groupby("damage_scale")["limit_state"].unique()
    for (variant, scale), group in curves.groupby(["variant", "damage_scale"], sort=True):
        rows = group.set_index("limit_state", drop=False)
        yield str(variant), str(scale), list(map(str, states[str(scale)])), rows


def _probabilities(curves: pd.DataFrame, intensities: Floats) -> pd.DataFrame:
    """Return exceedance probabilities, with one row per curve and intensity."""
    fitted = curves[curves["status"] == FITTED]
    names = [*variant_columns(fitted), "component", "limit_state", "method", "im"]
    long = fitted.reindex(columns=[*names, "im_low", "im_high"])
    long = long.merge(pd.DataFrame({"intensity": intensities}), how="cross")
    curves_of = [curve_probability(intensities, row) for row in records_of(fitted)]
    long["probability"] = np.concatenate(curves_of)
    names += ["intensity", "probability"]
    if "im_low" in fitted:  # tables of earlier versions have no range of intensities
        long["extrapolated"] = ~long["intensity"].between(long["im_low"], long["im_high"])
        names.append("extrapolated")
    return long[names]


def _skew_factors(curves: pd.DataFrame, medians: pd.DataFrame) -> pd.DataFrame:
    """Return the ratios of medians at each skew to the median at skew 0, with intervals."""
    fitted = curves[curves["status"] == FITTED]
    skew, *columns = SKEW_FACTOR_COLUMNS
    others = [name for name in axis_names(fitted) if name != skew]
    keys = ["bridge", "abutment", *others, "component", "limit_state"]
    values = ["theta", "var_ln_theta", "variant", "extrapolated"]
    ends = ["skew_ratio_low", "skew_ratio_high"]
    straight = fitted.loc[fitted[skew] == 0].reindex(columns=[*keys, *values])
    skewed = with_ratios(fitted.loc[fitted[skew] != 0], medians[medians["from_value"] == 0])
    skewed = skewed.reindex(columns=[*keys, skew, "im", *values, *ends])
    both = skewed.merge(straight, on=keys, suffixes=("", "_straight"))
    if both.empty:
        raise InputError("no limit state has an estimate both at skew 0 and at another skew")
    both["factor"] = both["theta"] / both["theta_straight"]
    outside = both[["extrapolated", "extrapolated_straight"]].eq(other=True)
    both["extrapolated"] = outside.any(axis=1)
    # ASSUME medians are independent if there is no paired interval: the interval is then too wide,
    # never too narrow, because the motions are the same at both skews
    variance = both["var_ln_theta"] + both["var_ln_theta_straight"]
    low, high = (both[end].astype(np.float64) for end in ends)
    paired = pd.Series(0.5 * np.log(high / low))
    half = paired.fillna(variance**0.5 * float(special.ndtri(0.95)))
    both["interval"] = np.where(paired.isna(), "independent", "paired")
    both["factor_low"] = both["factor"] * np.exp(-half)
    both["factor_high"] = both["factor"] * np.exp(half)
    both["hazus_factor"] = hazus_factor(both[skew].to_numpy())
    return both[[*keys, skew, *columns, "variant_straight"]]


def _write_skew_scaling(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    """Write the skew factors as scaling specifications of pelicun to a JSON file.

    The file has one entry per skew, with the keys ``factor``, ``low`` and ``high`` (ends of the
    interval). Each value is an argument ``scaling_specification`` of pelicun's damage model for
    location 0 and direction 1. It applies to the curves without skew from ``--format pelicun``.
    """
    table = _skew_factors(curves, export.table("median_effects"))
    places: dict[tuple[str, str, str], tuple[str, str]] = {}
    for variant, scale, states, group in _functions(curves):
        name = identifier(f"{variant}.{scale}", *_PELICUN_ID)
        for number, state in enumerate(states, start=1):
            places[variant, group["component"].iloc[0], state] = f"{name}-0-1", f"LS{number}"
    scaling: dict[str, Any] = {}
    for row in table.to_dict("records"):
        name, number = places[row["variant_straight"], row["component"], row["limit_state"]]
        of_skew = scaling.setdefault(f"{row['skew_deg']:g}", {})
        for end in ("factor", "factor_low", "factor_high"):
            states = of_skew.setdefault(end.removeprefix("factor_"), {})
            states.setdefault(name, {})[number] = f"*{row[end]:.6g}"
    write_text(export.out, json.dumps(scaling, indent=1) + "\n")
    return {"notes": ["the scaling specification of each skew applies to curves without skew"]}


def identifier(name: str, signs: str, longest: int) -> str:
    """Return a name with _ for characters outside a regex class; a change adds a digest."""
    plain = re.sub(f"[^{signs}]", "_", name)
    if plain == name and len(name) <= longest:
        return name
    digest = digest_of(name)
    return f"{plain[: longest - len(digest) - 1]}_{digest}"


def measure_names(column: str) -> tuple[str, float, str, str]:
    """Return name and factor of an intensity in OpenQuake, demand type and unit in pelicun."""
    if match := re.match(r"im_sa_(\d+)p(\d+)_", column):
        period = f"{float(f'{match[1]}.{match[2]}'):g}"
        return f"SA({period})", 1.0, f"Spectral Acceleration|{period}", "g"
    matching = (names for start, names in _MEASURES.items() if column.startswith(start))
    return next(matching, ("", 1.0, "", ""))


def _write_nrml(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    """Write one function per variant and damage scale, with limit states sorted by threshold.

    All functions of an OpenQuake model have the same limit states. If the fitted states differ, one
    file is written per damage scale and set of states. The entry ``crossing`` of a file lists the
    functions whose curves cross near the medians; OpenQuake then has negative damage fractions.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[pd.DataFrame]] = defaultdict(list)
    for _, scale, known, rows in _functions(curves):
        states = tuple(name for name in known if rows["status"].get(name) == FITTED)
        if states:
            name = scale if len(states) == len(known) else "_".join((scale, *states))
            name = re.sub(r"[^A-Za-z0-9_-]+", "_", name)
            groups[name, states].append(rows.loc[list(states)])
    out, notes = export.out, list[str]()
    if len({states for _, states in groups}) == 1:
        ((_, states), *_), functions = groups, chain.from_iterable(groups.values())
        models = [_write_model(out, states, list(functions))]
    else:
        models = [
            _write_model(out.with_name(f"{out.stem}_{name}{out.suffix}"), states, functions)
            for (name, states), functions in groups.items()
        ]
        text = f"{len(models)} files, split by limit states, were written instead"
        notes.append(f"{out.name} was not written: {text}")
    if crossing := sum(len(model["crossing"]) for model in models):
        text = "OpenQuake computes negative damage fractions there"
        notes.append(f"curves cross in {crossing} functions: {text}")
    return {"models": models, "files": [model["file"] for model in models], "notes": notes}


def _write_model(
    path: Path, states: tuple[str, ...], functions: list[pd.DataFrame]
) -> dict[str, Any]:
    ElementTree.register_namespace("", _NRML)

    def add(parent: Element, tag: str, text: str | None = None, **values: str) -> Element:
        element = ElementTree.SubElement(parent, f"{{{_NRML}}}{tag}", values)
        element.text = text
        return element

    root = ElementTree.Element(f"{{{_NRML}}}nrml")
    kind = {"assetCategory": "bridges", "lossCategory": "structural"}
    model = add(root, "fragilityModel", id="skewbridge", **kind)
    text = "skewbridge, lognormal fits and unions; dispersion includes capacity dispersion"
    outside = [
        curves_of["variant"].iloc[0]
        for curves_of in functions
        if curves_of.get("extrapolated", _ABSENT).any()
    ]
    if outside := dict.fromkeys(map(str, outside)):
        text += f"; medians extrapolated beyond the motions in: {', '.join(outside)}"
    add(model, "description", text)
    add(model, "limitStates", " ".join(states))
    crossing: list[str] = []
    for curves_of in functions:
        variant, scale, column = map(str, curves_of[["variant", "damage_scale", "im"]].iloc[0])
        # source: simple_id of openquake.hazardlib.valid
        name = identifier(f"{variant}:{scale}", r"A-Za-z0-9_:\-", 75)
        theta, beta = curves_of["theta"].to_numpy(), curves_of["curve_beta"].to_numpy()
        measure, factor, *_ = measure_names(column)
        if not measure:
            advice = "fit with im_sa_1p000_rotd50_g or another Sa(T)"
            raise InputError(f"{column} has no name in OpenQuake: {advice}", column=column)
        rows = records_of(curves_of)
        # range: medians and 4 standard deviations; curves are checked for crossing within 2
        ends, side = np.log([theta.min(), theta.max()]), np.array([-1.0, 1.0]) * beta.max()
        low, high = factor * np.exp(ends + 4.0 * side)
        if unions := [union for row in rows if (union := union_curve(row)) is not None]:
            reach = [
                union.ln_theta + 4.0 * sign * union.beta for union in unions for sign in (-1, 1)
            ]
            reach = factor * np.exp([np.min(reach), np.max(reach)])
            levels = np.geomspace(min(low, reach[0]), max(high, reach[1]), _LEVELS)
            function = add(model, "fragilityFunction", id=name, format="discrete")
            text = " ".join(f"{level:.6g}" for level in levels)
            add(function, "imls", text, imt=measure, noDamageLimit=text.partition(" ")[0])
            for state, row in zip(curves_of["limit_state"], rows, strict=True):
                p = curve_probability(levels / factor, row)
                add(function, "poes", " ".join(f"{value:.8g}" for value in p), ls=str(state))
        else:
            function = add(
                model, "fragilityFunction", id=name, format="continuous", shape="logncdf"
            )
            limits = dict.fromkeys(("noDamageLimit", "minIML"), f"{low:.6g}")
            add(function, "imls", imt=measure, **limits, maxIML=f"{high:.6g}")
            mean = factor * theta * np.exp(0.5 * beta**2)
            deviation = mean * np.sqrt(np.expm1(beta**2))
            for state, m, s in zip(curves_of["limit_state"], mean, deviation, strict=True):
                add(function, "params", ls=str(state), mean=f"{m:.15g}", stddev=f"{s:.15g}")
        start, stop = ends + 2.0 * side
        grid = np.exp(np.linspace(start, stop, 400))
        curves = np.column_stack([curve_probability(grid, row) for row in rows])
        if (np.diff(curves, axis=1) > 1e-3).any():
            crossing.append(name)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)
    written = {"file": str(path), "limit_states": list(states), "functions": len(functions)}
    return written | {"crossing": crossing}


def _write_dlml(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    return _write_pelicun(curves, replace(export, out=export.out / "fragility.csv"))


def _write_pelicun(curves: pd.DataFrame, export: Export) -> dict[str, Any]:
    """Write one row per variant and damage scale; limit states are numbered from mild to severe.

    States without an estimate keep their number, because pelicun skips empty parameters. The report
    lists them as ``holes``. A JSON file with names is written next to the CSV file.
    """
    if export.skew_factors:
        return _write_skew_scaling(curves, export)
    out = export.out
    out.parent.mkdir(parents=True, exist_ok=True)
    if (names_file := out.with_suffix(".json")) == out:
        raise InputError(f"--out must end with .csv, got {out.name} (a .json file gets the names)")
    rows: list[dict[str, Any]] = []
    holes: list[dict[str, Any]] = []
    names: dict[str, Any] = {}
    for variant, scale, states, group in _functions(curves):
        of_state = {str(curve["limit_state"]): curve for curve in records_of(group)}
        fitted = {name: curve for name, curve in of_state.items() if curve["status"] == FITTED}
        if not fitted:
            continue
        column = str(group["im"].iloc[0])
        *_, demand, unit = measure_names(column)
        if not demand:
            raise InputError(f"{column} has no demand type in pelicun", column=column)
        name = identifier(f"{variant}.{scale}", *_PELICUN_ID)
        row: dict[str, Any] = {"ID": name, "Incomplete": 0, "Demand-Type": demand}
        # with Demand-Directional 0, pelicun takes 1.2 times the larger direction; ours is RotD50
        row |= {"Demand-Unit": unit, "Demand-Offset": 0, "Demand-Directional": 1}
        described: dict[str, Any] = {}
        missing: dict[str, str] = {}
        for number, state in enumerate(states, start=1):
            values: tuple[Any, ...] = ("", "", "", "")
            if curve := fitted.get(state):
                values = ("lognormal", curve["theta"], curve["curve_beta"], "")
                if union := union_curve(curve):
                    values = ("multilinear_CDF", _multilinear(union), "", "")
                dispersion = curve.get("capacity_dispersion", 0.0)
                capacity = f"median {curve['threshold']:g}"
                if not pd.isna(dispersion):  # the modes of a union have their own
                    capacity += f", dispersion {dispersion:g}"
                text = f"{state}: {curve['demand']} above {capacity}"
                if curve.get("extrapolated", False):
                    text += "; median extrapolated beyond the motions"
                source = {"Description": text, "Reference": str(curve.get("citation", ""))}
                # pelicun numbers damage states by the limit states that have parameters
                described[f"LS{number}"] = {f"DS{len(described) + 1}": source}
            else:
                status = of_state[state]["status"] if state in of_state else "no row"
                missing[state] = f"LS{number} {state} ({status})"
            row |= {f"LS{number}-{k}": v for k, v in zip(_PELICUN_PARAMETERS, values, strict=True)}
        comments = "dispersion includes capacity dispersion if a slope converts it"
        if missing:
            comments += f"; without an estimate: {', '.join(missing.values())}"
            holes.append({"id": name, "missing": list(missing)})
        methods = ", ".join(dict.fromkeys(str(curve["method"]) for curve in fitted.values()))
        names[name] = {
            "Description": f"{scale} of {variant}, {methods} fit",
            "Comments": comments,
            **{"SuggestedComponentBlockSize": "1 EA", "RoundUpToIntegerQuantity": "True"},
            "LimitStates": described,
        }
        rows.append(row)
    about = {
        "ShortName": "skewbridge",
        "Description": f"Fragility of {len(curves['variant'].unique())} bridge variants with "
        "seat-type abutments (skew, joint gap, friction) in " + str(curves["im"].iloc[0]),
        "Version": version("skewbridge"),
        "ComponentGroups": list(dict.fromkeys(row["ID"].split(".")[-1] for row in rows)),
        "References": sorted({str(text) for text in curves.get("citation", ())} - {""}),
    }
    write_csv(pd.DataFrame(rows), out)
    text = json.dumps({"_GeneralInformation": about, **names}, indent=1, allow_nan=False)
    write_text(names_file, f"{text}\n")
    text = f"{len(holes)} rows are incomplete: limit states without an estimate have no parameters"
    notes = [text] if holes else []
    return {"files": [str(out), str(names_file)], "holes": holes, "notes": notes}


def _multilinear(union: Union) -> str:
    """Return a union as points of its distribution, from 0 to 1, in the notation of pelicun."""
    # source: MultilinearCDFRandomVariable of pelicun/uq.py: strictly increasing, ends 0 and 1
    ln_im = np.linspace(union.quantile(-4.0), union.quantile(4.0), _LEVELS)
    im, p = np.exp(ln_im), np.round(union.probability(ln_im), 6)  # pelicun keeps 6 digits
    p, places = np.unique(p, return_index=True)
    points = np.array([[0.5 * im[0], *im[places], 1.1 * im[-1]], [0.0, *p, 1.0]])
    return "|".join(",".join(f"{value:.8g}" for value in axis) for axis in points)


#: Function that writes curves in each format and returns further entries of the report.
WRITERS: Final[Mapping[str, Callable[[pd.DataFrame, Export], dict[str, Any]]]] = {
    "nrml": _write_nrml,
    "pelicun": _write_pelicun,
    "dlml": _write_dlml,
    "csv": _write_csv,
    "latex": _write_latex,
}

"""Curves for papers and other programs: table of a paper, LaTeX, CSV, OpenQuake (NRML), pelicun.

Sources: OpenQuake engine manual (NRML 0.5, shape ``logncdf``: mean and stddev of the lognormal
variable, not of its logarithm); pelicun 3, fragility database.
"""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.metadata import version
from itertools import chain
from math import isnan
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.digests import digest_of
from skewbridge.files.tables import as_column, read_any, records_of, require, write_csv
from skewbridge.files.text import write_text
from skewbridge.fragility import demand_table
from skewbridge.fragility.demand_table import axis_names, described, variant_columns
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.settings import EFFECT_CONFIDENCE
from skewbridge.fragility.union import UNION_COLUMNS, Union, curve_probability, union_curve
from skewbridge.fragility.verdicts import RATIOS
from skewbridge.units import split_unit
from skewbridge.variant.axes import AXES, Axis, axes_of
from skewbridge.variant.variant import lacking_axes

_NEEDED: Final = (
    "variant", "component", "limit_state", "demand", "threshold", "method", "status", "im", "theta",
    "beta", "beta_total", "preferred",
)  # fmt: skip
#: Columns of a CSV of curves, described in `CURVE_COLUMNS`.
PARAMETERS: Final = (
    "component", "limit_state", "method", "im", "theta", "theta_low", "theta_high", "beta_total",
    "beta_total_low", "beta_total_high", "beta", "beta_low", "beta_high", "ci_method", "level",
    "status", "preferred", "warnings", "methods_ratio", "methods_differ", "n_exceed", "n_runs",
    "n_records", "n_unknown", "extrapolated", "demand", "threshold", "capacity_dispersion",
    "citation", *UNION_COLUMNS,
)  # fmt: skip
_NUMBERS: Final = "^(threshold|theta|beta|n_|capacity_|mode_)"  # columns of numbers
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
#: Column that is true if a median is outside the range of the motions.
EXTRAPOLATED: Final = "extrapolated"
_OTHER_MEASURE: Final = "fit with im_sa_1p000_rotd50_g or another Sa(T)"
_ABSENT: Final = pd.Series(dtype=np.bool_)  # replaces a missing column
_LEVELS: Final = 800  # of a curve that is a union; linear interpolation errs by less than 5e-5


def export_curves(source: Path, form: str, out: Path) -> dict[str, Any]:
    """Write the curves of a study for another tool or a paper, and return a report.

    Curves without an estimate are listed with their status in a CSV and omitted in other formats.
    The report lists them in ``unfitted``. It has the entry ``models`` for nrml, and ``holes`` for
    pelicun. An `InputError` names an unusable format, option, table or intensity measure.
    """
    if form not in WRITERS:
        raise InputError(f"format must be one of {', '.join(WRITERS)}, got {form!r}")
    table = read_any(source)
    demand_table.need_columns(table, _NEEDED, "the table of curves")
    for name in (*axis_names(table), *map(str, table.filter(regex=_NUMBERS))):
        values = as_column(table[name], name)
        if name in ("threshold", "theta", "beta", "beta_total"):
            require(~(values <= 0.0), name, "must be above zero", values)
    curves = chosen_curves(table).reset_index(drop=True)
    has_estimate = curves["status"] == FITTED
    if not has_estimate.any() and form != "csv":
        raise InputError(f"{source.name}: nothing to write, because no curve has an estimate")
    unfitted = curves.loc[~has_estimate, ["variant", "component", "limit_state", "status"]]
    counted = {
        "curves have no beta_total (no slope of the demand to convert the capacity dispersion): "
        "beta is exported instead": int(curves.loc[has_estimate, "beta_total"].isna().sum()),
        "states of variants have no estimate (listed by --json)": len(unfitted),
        "medians are extrapolated: fewer than three motions are as strong, or as weak, as the "
        "median": int(curves.get(EXTRAPOLATED, _ABSENT).eq(other=True).sum()),
    }
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        written = WRITERS[form](curves, out, source.parent)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error}") from error
    return {
        **{"format": form, "files": [str(out)], "left_out": len(unfitted)},
        **{"curves": int(has_estimate.sum()), **written},
        "notes": [
            "beta_total is exported: record-to-record and capacity dispersion",
            *(f"{count} {text}" for text, count in counted.items() if count),
            *written.get("notes", []),
        ],
        "unfitted": unfitted.astype(str).to_dict("records"),
    }


def _write_latex(curves: pd.DataFrame, out: Path, folder: Path) -> dict[str, Any]:
    paths = folder / "median_effects.parquet", folder / "joint.parquet"
    medians, joint = (
        read_any(path) if path.is_file() else pd.DataFrame(columns=list(described(path.stem)))
        for path in paths
    )
    write_text(out, latex_table(paper_table(curves, medians, joint)))
    missing = ", ".join(path.name for path in paths if not path.is_file())
    text = f"the table lacks what comes from {missing}, which must be next to the curves"
    return {"notes": [text] if missing else []}


def _write_csv(curves: pd.DataFrame, out: Path, _folder: Path) -> dict[str, Any]:
    names = (*variant_columns(curves), *PARAMETERS)
    write_csv(curves[[name for name in names if name in curves]], out)
    return {}


def _functions(curves: pd.DataFrame) -> Iterator[tuple[str, str, list[str], pd.DataFrame]]:
    """Yield variant, damage scale, states sorted by threshold, and curves indexed by state.

    A damage scale is a component, or component and state if the states of the component have
    different demands. The column ``curve_beta`` is beta_total, or beta if there is no slope to
    convert the dispersion of the capacity.
    """
    component = curves["component"].astype(str)
    one_demand = curves.groupby("component")["demand"].transform("nunique") == 1
    scales = component.where(one_demand, component + "_" + curves["limit_state"].astype(str))
    curves = curves.assign(curve_beta=curves["beta_total"].fillna(curves["beta"]))
    states = curves.sort_values("threshold", kind="stable").groupby(scales)["limit_state"].unique()
    for (variant, scale), group in curves.groupby(["variant", scales], sort=True):
        rows = group.set_index("limit_state", drop=False).assign(damage_scale=str(scale))
        yield str(variant), str(scale), list(map(str, states[str(scale)])), rows


def identifier(name: str, signs: str, longest: int) -> str:
    """Return a name with _ for characters outside ``signs``; changed names get a digest."""
    replaced = re.sub(f"[^{signs}]", "_", name)
    if replaced == name and len(name) <= longest:
        return name
    digest = digest_of(name)
    return f"{replaced[: longest - len(digest) - 1]}_{digest}"


def measure_names(column: str) -> tuple[str, float, str, str]:
    """Return OpenQuake's name and factor, and pelicun's demand type and unit, of an intensity."""
    if match := re.match(r"im_sa_(\d+)p(\d+)_", column):
        period = f"{float(f'{match[1]}.{match[2]}'):g}"
        return f"SA({period})", 1.0, f"Spectral Acceleration|{period}", "g"
    matching = (names for start, names in _MEASURES.items() if column.startswith(start))
    return next(matching, ("", 1.0, "", ""))


def _write_nrml(curves: pd.DataFrame, out: Path, _folder: Path) -> dict[str, Any]:
    """Write one function per variant and damage scale, with limit states sorted by threshold.

    All functions of an OpenQuake model have the same limit states. If the fitted states differ, one
    file is written per damage scale and set of states. The entry ``crossing`` of a file lists the
    functions whose curves cross near the medians; OpenQuake then has negative damage fractions.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[pd.DataFrame]] = defaultdict(list)
    for _, scale, all_states, rows in _functions(curves):
        if states := tuple(name for name in all_states if rows["status"].get(name) == FITTED):
            name = scale if len(states) == len(all_states) else "_".join((scale, *states))
            name = re.sub(r"[^A-Za-z0-9_-]+", "_", name)
            groups[name, states].append(rows.loc[list(states)])
    notes = list[str]()
    ending = out.suffix or ".xml"
    files = {out.with_name(f"{out.stem}_{n}{ending}"): f for (n, _), f in groups.items()}
    if len({states for _, states in groups}) == 1:
        files = {out: list(chain.from_iterable(groups.values()))}
    else:
        text = f"{len(files)} files, split by limit states, were written instead"
        notes.append(f"{out.name} was not written: {text}")
    models = [_write_model(path, functions) for path, functions in files.items()]
    if crossing := sum(len(model["crossing"]) for model in models):
        text = "OpenQuake computes negative damage fractions there"
        notes.append(f"curves cross in {crossing} functions: {text}")
    return {"models": models, "files": [model["file"] for model in models], "notes": notes}


def _write_model(path: Path, functions: list[pd.DataFrame]) -> dict[str, Any]:
    states = list(map(str, functions[0]["limit_state"]))
    ElementTree.register_namespace("", _NRML)

    def add(parent: Element, tag: str, text: str | None = None, **values: str) -> Element:
        element = ElementTree.SubElement(parent, f"{{{_NRML}}}{tag}", values)
        element.text = text
        return element

    root = ElementTree.Element(f"{{{_NRML}}}nrml")
    kind = {"assetCategory": "bridges", "lossCategory": "structural"}
    model = add(root, "fragilityModel", id="skewbridge", **kind)
    text = "skewbridge, lognormal fits and unions; dispersion includes capacity dispersion"
    variants = (f["variant"].iloc[0] for f in functions if f.get(EXTRAPOLATED, _ABSENT).any())
    if extrapolated := dict.fromkeys(map(str, variants)):
        text += f"; medians extrapolated beyond the motions in: {', '.join(extrapolated)}"
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
            raise InputError(f"{column} has no name in OpenQuake: {_OTHER_MEASURE}", column=column)
        rows = records_of(curves_of)
        # range: medians and 4 standard deviations; curves are checked for crossing within 2
        ln_ends, width = np.log([theta.min(), theta.max()]), np.array([-1.0, 1.0]) * beta.max()
        low, high = factor * np.exp(ln_ends + 4.0 * width)
        if unions := [union for row in rows if (union := union_curve(row)) is not None]:
            ln_range = [union.ln_theta + z * union.beta for union in unions for z in (-4.0, 4.0)]
            first, last = factor * np.exp([np.min(ln_range), np.max(ln_range)])
            levels = np.geomspace(min(low, first), max(high, last), _LEVELS)
            function = add(model, "fragilityFunction", id=name, format="discrete")
            text = " ".join(f"{level:.6g}" for level in levels)
            add(function, "imls", text, imt=measure, noDamageLimit=text.partition(" ")[0])
            for state, row in zip(curves_of["limit_state"], rows, strict=True):
                p = curve_probability(levels / factor, row)
                add(function, "poes", " ".join(f"{value:.8g}" for value in p), ls=str(state))
        else:
            form = {"format": "continuous", "shape": "logncdf"}
            function = add(model, "fragilityFunction", id=name, **form)
            limits = dict.fromkeys(("noDamageLimit", "minIML"), f"{low:.6g}")
            add(function, "imls", imt=measure, **limits, maxIML=f"{high:.6g}")
            mean = factor * theta * np.exp(0.5 * beta**2)
            deviation = mean * np.sqrt(np.expm1(beta**2))
            for state, average, sd in zip(curves_of["limit_state"], mean, deviation, strict=True):
                add(function, "params", ls=str(state), mean=f"{average:.15g}", stddev=f"{sd:.15g}")
        start, stop = ln_ends + 2.0 * width
        grid = np.exp(np.linspace(start, stop, 400))
        curves = np.array([curve_probability(grid, row) for row in rows])
        if (np.diff(curves, axis=0) > 1e-3).any():
            crossing.append(name)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)
    written = {"file": str(path), "limit_states": states, "functions": len(functions)}
    return written | {"crossing": crossing}


def _write_pelicun(curves: pd.DataFrame, out: Path, _folder: Path) -> dict[str, Any]:
    """Write one row per variant and damage scale; limit states are numbered from mild to severe.

    States without an estimate keep their number, because pelicun skips empty parameters. The report
    lists them as ``holes``. A JSON file with names is written next to the CSV file.
    """
    if (names_file := out.with_suffix(".json")) == out:
        raise InputError(f"--out must end with .csv, got {out.name} (names go to a .json file)")
    rows: list[dict[str, Any]] = []
    holes: list[dict[str, Any]] = []
    names: dict[str, Any] = {}
    for variant, scale, states, group in _functions(curves):
        curve_of = {str(curve["limit_state"]): curve for curve in records_of(group)}
        fitted = {name: curve for name, curve in curve_of.items() if curve["status"] == FITTED}
        if not fitted:
            continue
        column = str(group["im"].iloc[0])
        *_, demand, unit = measure_names(column)
        if not demand:
            text = f"{column} has no demand type in pelicun: {_OTHER_MEASURE}"
            raise InputError(text, column=column)
        name = identifier(f"{variant}.{scale}", *_PELICUN_ID)
        row: dict[str, Any] = {"ID": name, "Incomplete": 0, "Demand-Type": demand}
        # with Demand-Directional 0, pelicun takes 1.2 times the larger direction; ours is RotD50
        row |= {"Demand-Unit": unit, "Demand-Offset": 0, "Demand-Directional": 1}
        described: dict[str, Any] = {}
        missing: dict[str, str] = {}
        for rank, state in enumerate(states, start=1):
            row |= dict.fromkeys((f"LS{rank}-{name}" for name in _PELICUN_PARAMETERS), "")
            if (curve := fitted.get(state)) is None:
                status = curve_of[state]["status"] if state in curve_of else "no row"
                missing[state] = f"LS{rank} {state} ({status})"
                continue
            values = ("lognormal", curve["theta"], curve["curve_beta"])
            if union := union_curve(curve):
                values = ("multilinear_CDF", _multilinear(union), "")
            row |= zip((f"LS{rank}-{name}" for name in _PELICUN_PARAMETERS), values, strict=False)
            text = f"{state}: {curve['demand']} above median {curve['threshold']:g}"
            dispersion = curve.get("capacity_dispersion", 0.0)
            if not pd.isna(dispersion):  # the modes of a union have their own
                text += f", dispersion {dispersion:g}"
            if curve.get(EXTRAPOLATED, False):
                text += "; median extrapolated beyond the motions"
            source = {"Description": text, "Reference": str(curve.get("citation", ""))}
            # pelicun numbers damage states by the limit states that have parameters
            described[f"LS{rank}"] = {f"DS{len(described) + 1}": source}
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
    general_info = {
        "ShortName": "skewbridge",
        "Description": f"Fragility of {len(curves['variant'].unique())} bridge variants with "
        "seat-type abutments (skew, joint gap, friction) in " + str(curves["im"].iloc[0]),
        "Version": version("skewbridge"),
        "ComponentGroups": list(dict.fromkeys(row["ID"].split(".")[-1] for row in rows)),
        "References": sorted({str(text) for text in curves.get("citation", ())} - {""}),
    }
    write_csv(pd.DataFrame(rows), out)
    text = json.dumps({"_GeneralInformation": general_info, **names}, indent=1, allow_nan=False)
    write_text(names_file, f"{text}\n")
    text = f"{len(holes)} rows are incomplete: limit states without an estimate have no parameters"
    notes = [text] if holes else []
    return {"files": [str(out), str(names_file)], "holes": holes, "notes": notes}


def _multilinear(union: Union) -> str:
    """Return a union as points of its distribution, from 0 to 1, in the notation of pelicun."""
    # source: MultilinearCDFRandomVariable of pelicun/uq.py: strictly increasing, ends 0 and 1
    ln_im = np.linspace(union.quantile(-4.0), union.quantile(4.0), _LEVELS)
    im, p = np.exp(ln_im), np.round(union.probability(ln_im), 6)  # pelicun keeps 6 digits
    p, distinct = np.unique(p, return_index=True)
    points = np.array([[0.5 * im[0], *im[distinct], 1.1 * im[-1]], [0.0, *p, 1.0]])
    return "|".join(",".join(f"{value:.8g}" for value in axis) for axis in points)


#: Function that writes curves in each format, given the file and the folder of other tables, and
#: returns further entries of the report.
WRITERS: Final[Mapping[str, Callable[[pd.DataFrame, Path, Path], dict[str, Any]]]] = {
    "nrml": _write_nrml,
    "pelicun": _write_pelicun,
    "csv": _write_csv,
    "latex": _write_latex,
}


# --- Table of a paper: medians, dispersions and ratios of medians

JOINT: Final = "joint"
_ENDS: Final = ("", "_low", "_high")
_STATE: Final = ("bridge", "abutment", "component", "limit_state")
_NONE: Final = "--"
#: Mark of a printed median that is outside the range of the motions.
DAGGER: Final = "†"


def paper_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return the column descriptions of the publication table for a study with these axes."""
    endings = {"": "estimate", "_low": "lower end", "_high": "upper end"}
    return described("table", axes) | {
        f"{split_unit(axis.name)[0]}_ratio{ending}": f"{meaning} of the ratio to the median at the "
        f"value of {axis.title} nearest to zero"
        for axis in reversed(axes)
        for ending, meaning in endings.items()
    }


PAPER_COLUMNS: Final = paper_columns(AXES)


def chosen_curves(curves: pd.DataFrame) -> pd.DataFrame:
    """Return the preferred curve, or else the first, per variant and limit state."""
    preferred_first = curves.sort_values("preferred", ascending=False, kind="stable")
    return preferred_first.drop_duplicates(["variant", "component", "limit_state"]).sort_index()


def with_ratios(curves: pd.DataFrame, medians: pd.DataFrame) -> pd.DataFrame:
    """Add to each curve, for every axis, the ratio to the median at its `reference_value`.

    The ratios are paired by motion. They are NaN if not available.
    """
    axes = axis_names(curves)
    state = curves["component"].astype(str) + "/" + curves["limit_state"].astype(str)
    numbers = dict.fromkeys(axes, np.float64)
    keys = curves[["bridge", "abutment", *axes]].assign(demand=state).astype(numbers)
    ratios: dict[str, Any] = {}
    for axis in axes:
        pairs = medians[(medians["scope"] == "variant") & (medians["axis"] == axis)]
        pairs = pairs.assign(**{axis: pairs["to_value"]}).reindex(columns=[*keys, *RATIOS])
        with_pairs = keys.merge(pairs.astype(numbers), how="left", validate="many_to_one")
        ratios |= _ratio(axis, [with_pairs[name].to_numpy() for name in RATIOS])
    return curves.assign(**ratios)


def paper_table(curves: pd.DataFrame, medians: pd.DataFrame, joint: pd.DataFrame) -> pd.DataFrame:
    """Return the table for publication, without limit states of which no variant has a curve."""
    selected = with_ratios(chosen_curves(curves), medians)
    joint = joint.merge(selected.loc[selected["theta"].notna(), list(_STATE)].drop_duplicates())
    # all runs count, as in the rows of variants: those without information on the demand as well
    runs = selected.groupby(list(_STATE))["n_runs"].sum()
    rows = records_of(selected.assign(row=selected["variant"]))
    for row in records_of(joint[joint["status"] == FITTED]):
        model = JointModel(row)
        out = {name: row[name] for name in PAPER_COLUMNS if name in row}
        middle = model.axis_range.middle
        for axis in middle:
            levels = model.axis_range.levels[axis]
            start, end = (
                middle | {axis: choose(levels)}
                for choose in (demand_table.reference_value, demand_table.farthest_value)
            )
            out |= _ratio(axis, model.median(end, start, EFFECT_CONFIDENCE))
        out["n_runs"] = runs[tuple(row[name] for name in _STATE)]
        rows.append(out | {"row": JOINT, "method": JOINT})
    table = pd.DataFrame(rows, columns=list(paper_columns(_axes(curves))))
    table = table[table.groupby(list(_STATE))["theta"].transform("count") > 0]
    # in the order of the last row of each state
    order = curves.drop_duplicates(list(_STATE), keep="last")[list(_STATE)]
    return order.merge(table)[list(table)]


def _axes(table: pd.DataFrame) -> tuple[Axis, ...]:
    """Return the axes of a table, always including the core axes."""
    return axes_of([*(axis.name for axis in AXES), *axis_names(table)])


def _ratio(axis: str, values: Sequence[Any]) -> dict[str, Any]:
    name = split_unit(axis)[0]
    return {f"{name}_ratio{ending}": value for ending, value in zip(_ENDS, values, strict=True)}


def ratio_names(table: pd.DataFrame) -> list[str]:
    """Return the names, without unit, of axes with at least one ratio in a publication table."""
    names = (split_unit(axis.name)[0] for axis in reversed(_axes(table)))
    return [name for name in names if table[f"{name}_ratio"].notna().any()]


def variant_in_words(row: Mapping[str, Any]) -> str:
    """Return the axis values of a variant as text: ``skew 30 deg, gap 51 mm, friction 0.5``."""
    return ", ".join(
        f"{axis.label.lower()} {row[axis.name]:g} {axis.unit}".removesuffix(" -")
        for axis in axes_of(row)
        if axis.name not in lacking_axes(str(row["abutment"])) and not isnan(row[axis.name])
    )


def printed_rows(table: pd.DataFrame) -> list[dict[str, str]]:
    """Return the publication table as texts; *: medians of methods differ, †: extrapolated."""
    ratios, marks = ratio_names(table), {"methods_differ": " *", EXTRAPOLATED: f" {DAGGER}"}
    return [
        {
            "model": f"{row['bridge']} {row['abutment']}".replace("_", " "),
            "variant": "joint model" if row["row"] == JOINT else variant_in_words(row),
            "state": f"{row['component']}, {row['limit_state']}".replace("_", " "),
            "theta": _interval(row, "theta")
            + "".join(mark for name, mark in marks.items() if row.get(name) is True),
            "total": _interval(row, "beta_total"),
            "beta": three_digits(row["beta"]),
            "exceed": f"{row['n_exceed']:.0f} of {row['n_runs']:.0f}",
            **{name: _interval(row, f"{name}_ratio") for name in ratios},
        }
        for row in records_of(table)
    ]


_LATEX_HEADS: Final = {
    "model": "Bridge",
    "variant": "Variant",
    "state": "Component, state",
    "theta": r"$\theta$ [interval]",
    "total": r"$\beta_\mathrm{total}$ [interval]",
    "beta": r"$\beta_\mathrm{records}$",
    "exceed": "exceed",
}


def latex_table(table: pd.DataFrame) -> str:
    """Return the publication table as LaTeX text (packages booktabs and longtable)."""
    rows = printed_rows(table)
    names = list(rows[0]) if rows else list(_LATEX_HEADS)
    heads = " & ".join(_LATEX_HEADS.get(name, f"{name.replace('_', ' ')} ratio") for name in names)
    units = ", ".join(sorted(set(table["im"].astype(str))))
    cells = ([re.sub("[_%&]", r"\\\g<0>", text) for text in row.values()] for row in rows)
    return "\n".join(
        [
            r"% needs \usepackage{booktabs,longtable}",
            f"% medians in {units}; ratios to the median at the value of each axis nearest to zero",
            "% beta_total: dispersion of the curve, including capacity dispersion;",
            "% beta_records: record-to-record dispersion",
            "% *: cloud and exceedance medians differ by more than 2 standard errors",
            f"% {DAGGER}: extrapolated, fewer than three motions are as strong or as weak",
            "% failure in any mode: median and half of the ln range from 16 to 84 % of a union",
            rf"\begin{{longtable}}{{lll{'r' * (len(names) - 3)}}}",
            *(r"\toprule", heads + r" \\", r"\midrule", r"\endhead"),
            *(" & ".join(texts) + r" \\" for texts in cells),
            *(r"\bottomrule", r"\end{longtable}", ""),
        ]
    )


def with_interval(values: Sequence[float]) -> str:
    """Return text with an estimate and its interval, from (value, lower end, upper end)."""
    estimate, low, high = map(three_digits, values)
    return estimate if _NONE in (estimate, low) else f"{estimate} [{low}, {high}]"


def _interval(row: Mapping[str, Any], name: str) -> str:
    return with_interval([row[f"{name}{ending}"] for ending in _ENDS])


def three_digits(value: float) -> str:
    """Return a number with three significant digits, such as ``1.60``; ``--`` for NaN."""
    return _NONE if pd.isna(value) else f"{value:#.3g}".rstrip(".")

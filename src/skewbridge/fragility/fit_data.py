"""Fit a data file: counts per level, capacities, a cloud of demands or a table of runs."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, Literal, Self

import numpy as np
import pandas as pd
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.demands.columns import EVENT
from skewbridge.demands.validity import is_complete
from skewbridge.errors import InputError
from skewbridge.files.tables import as_column, positive, read_any, require, same_length
from skewbridge.files.text import checked, file_fault, read_json, read_yaml, shortened, shown_path
from skewbridge.fragility import demand_table, fits
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED, MAX_BOUNDS_RATIO, NO_EXCEEDANCE
from skewbridge.fragility.limit_states import COLLAPSE_PEAK, LimitState
from skewbridge.fragility.motion_means import motion_weights
from skewbridge.fragility.outcomes import TREATMENTS, DemandOutcomes, demand_outcomes
from skewbridge.fragility.settings import DEFAULTS, FitSettings

#: Note on a table without motions.
_INDEPENDENT: Final = "there is no column motion_id: the runs are taken as independent"
#: Other names of our columns in published data sets.
_ALIASES: Final = demand_table.ALIASES | {
    "bracketlo": "lower", "brackethi": "upper",
    "imnoexceed": "lower", "imexceed": "upper",
}  # fmt: skip
#: Columns by which the method of data is known.
_COLUMNS: Final = {
    "stripes": ({"im", "n", "k"},),
    "ida": ({"capacity"}, {"lower", "upper"}),
    "cloud": ({"im", "edp"}, {"ln_im", "ln_edp"}),
}
#: Intensities or capacities of data without a row per run; those of runs are named im_...
_PLAIN: Final = {"im", "ln_im", "capacity", "lower", "upper"}


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """Options of ``skewbridge fit``."""

    method: Literal["stripes", "ida", "cloud"]
    #: Model of a cloud; None: ols, or tobit if some demands are censored.
    model: Literal["ols", "tobit"] | None = None
    link: Literal["probit"] = "probit"  # curves are lognormal
    level: float = Field(default=DEFAULTS.confidence, gt=0.5, lt=1.0)
    threshold: float | None = None  # median capacity, if the file does not give it
    im: str | None = None  # column of intensities, for a table of runs
    edp: str | None = None  # column of demands, for a table of runs
    columns: Path | None = None  # file that maps the columns of a foreign table to ours

    @model_validator(mode="after")
    def _of_a_cloud(self) -> Self:
        if self.model and self.method != "cloud":
            raise ValueError(f"--model needs --method cloud, not {self.method}")
        return self

    @property
    def is_plain(self) -> bool:
        """Whether the data are a cloud whose columns are ``im`` and ``edp``, not named."""
        return self.method == "cloud" and self.im is None and self.edp is None

    @property
    def settings(self) -> FitSettings:
        """Settings of the fit."""
        return FitSettings(confidence=self.level)


def fit_file(path: Path, **option_values: Any) -> fits.FragilityFit:
    """Fit the data in a file. An `InputError` names the option, or the file, column and row."""
    if not option_values.get("method"):
        columns = {*demand_table.our_names(read_data(path), _ALIASES).values()}
        known = [name for name, sets in _COLUMNS.items() if any(map(columns.issuperset, sets))]
        of_runs = "cloud, stripes or ida, with --im, --edp and --threshold"
        raise InputError(f"--method is needed; for {path.name}: {' or '.join(known) or of_runs}")
    options = checked(FitOptions, option_values, "options of the fit")
    if options.columns is None:
        data = read_data(path)
    else:
        name, content = options.columns.name, read_yaml(options.columns)
        column_map = checked(demand_table.ColumnMap, content, name)
        is_plain = _PLAIN & column_map.columns.keys()
        renamed = _renamed if is_plain else demand_table.read_foreign
        data = renamed(path, read_any(path), column_map)
    own: dict[object, str] = {name: name for name in (options.im, options.edp) if name}
    names = demand_table.our_names(data, _ALIASES) | own
    columns = {names[name]: values for name, values in data.items()}
    of_runs = options.method == "cloud" or options.edp or options.im
    try:
        return (_fit_runs if of_runs else _fit_columns)(columns, options)
    except InputError as error:
        if not {"row", "column"} & error.details.keys():  # the error concerns options, not the file
            raise
        details = {"file": str(path), **error.details}
        raise InputError(f"{shown_path(path)}: {error}", **details) from error


def _renamed(path: Path, source: pd.DataFrame, names: demand_table.ColumnMap) -> pd.DataFrame:
    """Return the mapped columns of a table without a row per run, in our units."""
    columns, factors = names.columns, names.factors.items()
    demand_table.need_columns(source, columns.values(), path.name)
    table = source[[*columns.values()]].set_axis([*columns], axis=1)
    scaled = {n: as_column(table[n].to_numpy(), columns[n]) * factor for n, factor in factors}
    return table.assign(**names.constants, **scaled)


def read_data(path: Path) -> pd.DataFrame | Mapping[str, Any]:
    """Read a table from CSV, parquet or JSON (an object with columns, or a list of rows)."""
    suffix = path.suffix.lower()
    if suffix in {".csv", ".parquet"}:
        return read_any(path)
    if suffix != ".json":
        raise file_fault(path, " must end with .json, .csv or .parquet")
    data: Any = read_json(path)
    if isinstance(data, list) and all(isinstance(row, dict) for row in data):
        return pd.DataFrame(data)
    if not isinstance(data, dict):
        raise file_fault(path, " must contain a JSON object with a list per column, or rows")
    return data


def _need(columns: Mapping[str, Any], options: FitOptions, name: str) -> Any:
    if name not in columns:
        text = f"{options.method} data need a column {name!r} (--columns maps names); found "
        raise InputError(text + demand_table.names_of(columns), column=name)
    return columns[name]


def _fit_columns(columns: Mapping[str, Any], options: FitOptions) -> fits.FragilityFit:
    """Fit columns of numbers: counts, capacities or brackets."""
    settings, need = options.settings, partial(_need, columns, options)
    if options.method == "stripes":
        return fits.fit_stripes(need("im"), need("n"), need("k"), settings=settings)
    if options.method == "ida" and ("lower" in columns or "upper" in columns):
        # JSON has no infinity: null or the text "inf" is an open end
        return fits.fit_brackets(need("lower"), need("upper"), settings)
    return fits.fit_capacities(need("capacity"), columns.get("censored"), settings)


def _fit_runs(columns: Mapping[str, Any], options: FitOptions) -> fits.FragilityFit:
    """Fit a table with one row per run; statuses and repeated motions are taken into account.

    Without --im and --edp, a cloud has the columns ``im`` and ``edp`` or their logarithms. Its
    demands must be positive, and its median may be above all of them.
    """
    is_plain = options.is_plain
    if options.method == "cloud":
        columns, options = _cloud(columns, options)
    if options.im is None or options.edp is None or options.threshold is None:
        raise InputError("runs need --im, --edp and --threshold; capacities or counts --columns")
    by_run = {key: value for key, value in columns.items() if isinstance(value, list | pd.Series)}
    same_length(**by_run)
    data = pd.DataFrame(by_run)
    demand_table.need_columns(data, (options.im, options.edp), "the table")
    unused = set(map(str, data)) - {options.im, options.edp, *demand_table.FLAGS}
    demand_table.refuse_misspelt(unused)
    im = positive(data[options.im].to_numpy(), options.im)
    demand = as_column(data[options.edp].to_numpy(), options.edp)
    runs = demand_table.with_flags(data).assign(**{options.edp: demand})
    is_valid = demand > 0.0 if is_plain else demand >= 0.0
    is_valid = (np.isfinite(demand) & is_valid) | ~is_complete(runs)
    advice = f"peaks are absolute; {demand_table.WITHOUT_PEAK}"
    rule = f"must be {'>' if is_plain else '>='} 0 and finite in runs that completed ({advice})"
    require(is_valid, options.edp, rule, demand)
    state = LimitState(
        component=options.edp,
        name="threshold",
        demand=options.edp,
        threshold=float(positive([options.threshold], "threshold")[0]),
        dispersion=0.0,
    )
    has_motions = "motion_id" in data
    motions = demand_table.motion_codes(data) if has_motions else np.arange(im.size)
    notes = [] if has_motions else [_INDEPENDENT]
    notes += demand_table.unused_notes(unused)
    if varying := demand_table.varying_axes(data):
        notes += [f"one curve for all values of {demand_table.names_of(varying)}"]
    if options.method != "ida" and not demand_table.has_common_steps(np.log(im), motions):
        notes += ["motions have different levels: use --method ida if they follow outcomes"]
    rows = pd.DataFrame({"im": im, "edp": demand, "motion": motions * has_motions})
    if repeated := int(rows.dropna().duplicated().sum()):
        text = "intervals are too narrow if runs were entered twice"
        notes += [f"{repeated} runs repeat intensity and demand of another run: {text}"]
    notes += [*filter(None, [state.doubt]), *demand_table.percent_notes(options.im, im)]
    if state.threshold <= demand_table.MAX_DRIFT:
        notes += demand_table.percent_notes(options.edp, demand[is_complete(runs)])
    outcomes = demand_outcomes(runs, [state])
    # the jackknife leaves out events where they are known
    by_event = has_motions and EVENT in data and options.method != "ida"
    codes = demand_table.block_codes(data) if by_event else motions
    fit_of = partial(_fit_outcomes, im, codes, state, options, extrapolates=is_plain)
    fit, unknown = fit_of(outcomes), outcomes.unknown(state)
    bounds: dict[str, tuple[float, float]] = {}
    details: dict[str, Any] = {"n_records": int(np.unique(motions).size)}
    details |= {"n_unknown": int(np.sum(unknown)), "notes": notes}
    if np.any(unknown):
        for name in TREATMENTS:
            bound_fit = fit_of(outcomes.treated(state, name))
            bounds[name] = bound_fit.theta, bound_fit.beta
            details |= {f"theta_{name}": bound_fit.theta, f"beta_{name}": bound_fit.beta}
        fit = fit.limited(bounds)
    if options.method == "cloud" and fit.status == FITTED:
        # no estimate may rest on the definition that a collapse exceeds
        peaks = demand_outcomes(runs, [replace(state, collapse=COLLAPSE_PEAK)])
        peak_fit = fit_of(peaks)
        if not 1.0 / MAX_BOUNDS_RATIO <= peak_fit.theta / fit.theta <= MAX_BOUNDS_RATIO:
            fit = fit.without_estimate(BOUNDS_TOO_WIDE)
    return replace(fit, details={**fit.details, **details})


def _cloud(columns: Mapping[str, Any], options: FitOptions) -> tuple[Mapping[str, Any], FitOptions]:
    """Return a cloud, and options that name its intensities, demands and threshold."""
    columns, names = dict(columns), {"im": options.im or "im", "edp": options.edp or "edp"}
    if options.is_plain:
        for name in ("im", "edp", *(["threshold"] if options.threshold is None else [])):
            if f"ln_{name}" not in columns:
                _need(columns, options, name)
    for name in names.values():
        if (logarithm := f"ln_{name}") in columns:
            columns[name] = np.exp(as_column(columns.pop(logarithm), logarithm))
        if name in columns:
            columns[name] = pd.Series(as_column(columns[name], name))
    stated = columns.pop("threshold", None)
    if options.threshold is None and stated is not None:
        thresholds = np.unique(positive(np.atleast_1d(stated).tolist(), "threshold")).tolist()
        if len(thresholds) != 1:
            text = f"threshold must be one number, got {shortened(thresholds)}"
            raise InputError(text, column="threshold")
        options = replace(options, threshold=thresholds[0])
    return columns, replace(options, **names)


def _fit_outcomes(
    im: Any,
    motions: Any,
    state: LimitState,
    options: FitOptions,
    outcomes: DemandOutcomes,
    *,
    extrapolates: bool,
) -> fits.FragilityFit:
    """Fit the outcomes of n runs with ``options.method``; ``im`` and ``motions`` are (n,)."""
    exceed, is_known, is_used = outcomes.exceed(state), ~outcomes.unknown(state), outcomes.used
    settings = options.settings
    if options.method == "cloud":
        cloud, count = outcomes.of(np.flatnonzero(is_used)), int(np.sum(outcomes.is_bound))
        if options.model == "ols" and count:
            text = f"--model ols would leave out {count} censored demands: use --model tobit"
            raise InputError(text)
        fit = fits.fit_cloud(
            im[is_used], cloud.lower, state.threshold, cloud.upper, settings=settings,
            motions=motions[is_used],
        )  # fmt: skip
        return fit if extrapolates or np.any(exceed) else fit.without_estimate(NO_EXCEEDANCE)
    x, hit, codes = im[is_known], exceed[is_known].astype(np.float64), motions[is_known]
    if options.method == "ida":
        return fits.fit_first_exceedances(x, hit, codes, settings)
    count, ones = int(np.unique(codes).size), np.ones(x.size)
    one_run_each = count == codes.size
    fit = fits.fit_stripes(x, ones, hit, settings=settings, n_records=count, interval=one_run_each)
    if fit.status != FITTED or one_run_each:
        return fit
    subset_fits = [
        fits.fit_stripes(x[rows], ones[rows], hit[rows], settings=settings, interval=False)
        for rows in motion_weights(codes) > 0.0
    ]
    theta, beta = np.transpose([(of_subset.theta, of_subset.beta) for of_subset in subset_fits])
    return fits.jackknifed(fit, np.log(theta), beta)

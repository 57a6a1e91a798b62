"""From a file and options to a fit: the work behind `skewbridge fit`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_data
from skewbridge.fragility.likelihood.fit import FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.parts import RunCounts
from skewbridge.fragility.likelihood.validate import as_column, as_list, same_length
from skewbridge.fragility.methods import cloud, cloud_models, ida, stripes, tobit
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_beyond_model
from skewbridge.fragility.tables.key_columns import motion_codes, need_columns
from skewbridge.fragility.tables.limit_states import MAX_DISPERSION, LimitState
from skewbridge.fragility.tables.outcomes import Runs, outcomes_of
from skewbridge.fragility.tables.variant_cloud import fit_variant_cloud
from skewbridge.fragility.tables.variant_exceedance import fit_exceedance, fit_record_brackets
from skewbridge.reading import shortened
from skewbridge.statuses import OK

METHODS: Final = ("stripes", "ida", "cloud")
MODELS: Final = ("ols", "tobit", "modified", "heteroscedastic")
MAX_ASSUMED_BETA: Final = 5.0
MOST_NAMED: Final = 20  # columns in a message
# Other spellings of the columns, as they stand in published data sets.
_ALIASES: Final = {
    "right_censored": "censored",
    "bracket_lo": "lower",
    "bracket_hi": "upper",
    "im_no_exceed": "lower",
    "im_exceed": "upper",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """Options of the command.

    Attributes:
        method: stripes, ida or cloud.
        model: Cloud model; None is ols, or modified where runs collapsed.
        link: Link of the stripes.
        level: Confidence level.
        threshold: Median capacity, if the file does not give it.
        im: Column of intensities, for a table of runs.
        edp: Column of demands, for a table of runs.
        where: Condition that selects rows of a table (`rows_where`).
        capacity_dispersion: Dispersion of the capacity (cloud ols and tobit).
        censor_above: Demands at or above it are censored (tobit).
        discard_below: Demands below it are dropped (tobit); selects on the response.
        assumed_beta: Dispersion for one-sided bounds.
        accept_bounds: Give a number though unknown outcomes move it by over 15 %.
    """

    method: str
    model: str | None = None
    link: str = "probit"
    level: float = DEFAULTS.confidence
    threshold: float | None = None
    im: str | None = None
    edp: str | None = None
    where: str | None = None
    capacity_dispersion: float = 0.0
    censor_above: float | None = None
    discard_below: float | None = None
    assumed_beta: float = DEFAULTS.assumed_beta
    accept_bounds: bool = False

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"method must be one of {', '.join(METHODS)}, got {self.method!r}")
        if self.model is not None and self.model not in MODELS:
            raise InputError(f"model must be one of {', '.join(MODELS)}, got {self.model!r}")
        widest, most = MAX_DISPERSION, MAX_ASSUMED_BETA
        for name, inside, limits in (
            ("level", 0.5 < self.level < 1.0, "0.5..1"),
            ("assumed_beta", 0.0 < self.assumed_beta <= most, f"0..{most:g} (not 0)"),
            ("capacity_dispersion", 0.0 <= self.capacity_dispersion <= widest, f"0..{widest:g}"),
        ):
            if not inside:
                raise InputError(f"{name} must be within {limits}, got {getattr(self, name):g}")

    @property
    def settings(self) -> FitSettings:
        """The options that every fit takes."""
        return FitSettings(
            confidence=self.level, accept_bounds=self.accept_bounds, assumed_beta=self.assumed_beta
        )


def fit_file(path: Path, options: FitOptions) -> FragilityFit:
    """Fit the data of a JSON, CSV or parquet file.

    Raises:
        InputError: The file or a value in it is unusable; the details hold the row.
    """
    data = read_data(path, options.where)
    try:
        return _fit_data(data, options)
    except InputError as error:
        row = error.details.get("row")
        if options.where is None or not isinstance(row, int) or not isinstance(data, pd.DataFrame):
            raise
        of_file = int(data.index.to_numpy()[row])
        raise InputError(
            f"{error} of the {len(data)} selected; row {of_file} of the file",
            **(error.details | {"row": of_file}),
        ) from error


def _fit_data(data: pd.DataFrame | Mapping[str, Any], options: FitOptions) -> FragilityFit:
    if options.edp is not None or options.im is not None:
        if not isinstance(data, pd.DataFrame):
            lists = {str(name): value for name, value in data.items() if isinstance(value, list)}
            same_length(**{name: np.empty(len(value)) for name, value in lists.items()})
            data = pd.DataFrame(lists)
        return _fit_runs(data, options)
    columns = {_ALIASES.get(str(key), str(key)): value for key, value in dict(data).items()}
    return _fit_columns(columns, options)


def _fit_columns(columns: Mapping[str, Any], options: FitOptions) -> FragilityFit:
    def need(name: str) -> Any:
        if name not in columns:
            found = ", ".join(map(shortened, list(columns)[:MOST_NAMED])) or "none"
            raise InputError(
                f"{options.method} data need a column {name!r}; found {found}",
                column=name,
            )
        return columns[name]

    if options.method == "stripes":
        counts = (need("im"), need("n"), need("k"))
        return stripes.fit_stripes(*counts, link=options.link, settings=options.settings)
    if options.method == "ida":
        if "lower" in columns or "upper" in columns:
            lower, upper = (
                need("lower"),
                [_endless(value) for value in as_list(need("upper"), "upper")],
            )
            return ida.fit_brackets(lower, upper, options.settings)
        return ida.fit_capacities(need("capacity"), columns.get("censored"), options.settings)
    im = np.exp(as_column(columns["ln_im"], "ln_im")) if "ln_im" in columns else need("im")
    edp = np.exp(as_column(columns["ln_edp"], "ln_edp")) if "ln_edp" in columns else need("edp")
    threshold = options.threshold
    if threshold is None:
        given = np.atleast_1d(need("threshold"))[:1].tolist()
        if not given:
            raise InputError("the column threshold is empty: one number is needed")
        threshold = float(as_column(given, "threshold")[0])
    if "censored" in columns:
        return _fit_tobit(im, edp, threshold, columns["censored"], options)
    collapse = columns.get("collapse")
    flags = None if collapse is None else as_column(collapse, "collapse")
    return _fit_cloud(im, edp, threshold, flags, options)


def _fit_cloud(
    im: Any, edp: Any, threshold: float, collapse: FloatArray | None, options: FitOptions
) -> FragilityFit:
    fallen = collapse is not None and bool(np.any(collapse > 0.0))
    model = options.model or ("modified" if fallen else "ols")
    if model == "modified":
        flags = np.zeros(len(im)) if collapse is None else collapse
        return cloud_models.fit_modified_cloud(im, edp, threshold, flags, level=options.level)
    if model == "tobit":
        demand = as_column(edp, "edp")
        if collapse is not None and fallen:  # a collapse exceeds, whatever was recorded
            demand = np.where(collapse > 0.0, np.fmax(demand, threshold), demand)
        return _fit_tobit(im, demand, threshold, collapse, options)
    x, d = as_column(im, "im"), as_column(edp, "edp")
    if collapse is not None and fallen and collapse.size == x.size == d.size:
        cloud.cloud_columns(x, d, threshold, collapse)
        x, d = x[collapse == 0.0], d[collapse == 0.0]
    if model == "heteroscedastic":
        fit = cloud_models.fit_heteroscedastic(x, d, threshold, level=options.level)
    else:
        fit = cloud.fit_cloud(
            x,
            d,
            threshold,
            capacity_dispersion=options.capacity_dispersion,
            settings=options.settings,
        )
    return replace(fit, warnings=(*fit.warnings, "collapse_left_out")) if fallen else fit


def _fit_tobit(
    im: Any, edp: Any, threshold: float, censored: Any, options: FitOptions
) -> FragilityFit:
    x, demand, upper = tobit.censored_cloud(
        im, edp, censored, above=options.censor_above, discard_below=options.discard_below
    )
    return tobit.fit_tobit(
        x,
        demand,
        threshold,
        upper,
        capacity_dispersion=options.capacity_dispersion,
        settings=options.settings,
    )


def _fit_runs(table: pd.DataFrame, options: FitOptions) -> FragilityFit:
    """Fit a table with one row per run; ``status``, ``beyond_model``, ``motion_id`` are obeyed."""
    if options.im is None or options.edp is None or options.threshold is None:
        raise InputError("a table of runs needs --im, --edp and --threshold")
    need_columns(table, (options.im, options.edp), "the table")
    beyond = is_beyond_model(table)
    ended = "status" not in table.columns or bool((table["status"] == OK).all())
    plain = ended and not np.any(beyond)
    alone = "motion_id" not in table.columns or bool(table["motion_id"].is_unique)
    im = as_column(table[options.im].to_numpy(), options.im)
    if options.method == "cloud" and plain and (alone or options.model is not None):
        flags = table["collapse"].to_numpy() if "collapse" in table.columns else None
        collapse = None if flags is None else as_column(flags, "collapse")
        edp = table[options.edp].to_numpy()
        return _fit_cloud(im, edp, options.threshold, collapse, options)
    x, _, _ = cloud.cloud_columns(im, np.ones(im.size), options.threshold)
    status = np.full(x.size, OK) if "status" not in table.columns else table["status"].to_numpy(str)
    codes = motion_codes(table) if "motion_id" in table.columns else np.arange(x.size)
    runs = Runs(im=im, status=status, beyond=beyond, records=codes)
    state = LimitState(
        component=options.edp,
        name="threshold",
        demand=options.edp,
        threshold=options.threshold,
        dispersion=options.capacity_dispersion,
    )
    demand = as_column(table[options.edp].to_numpy(), options.edp)
    outcomes = outcomes_of(demand, status, beyond, state)
    cloud.cloud_columns(im, demand, options.threshold, (~outcomes.complete).astype(np.float64))
    if options.method == "cloud":
        fit = fit_variant_cloud(runs, outcomes, state, options.settings)
    elif options.method == "ida":
        fit = fit_record_brackets(runs, outcomes, options.settings)
    else:
        fit = fit_exceedance(runs, outcomes, options.settings)
    counts = replace(
        fit.counts or RunCounts(),
        n_records=int(np.unique(codes).size),
        n_unknown=int(np.sum(outcomes.unknown)),
    )
    return replace(fit, counts=counts)


def _endless(value: Any) -> Any:
    """Read the text "inf" (JSON has no infinity) and null as an open end."""
    return None if value is None or (isinstance(value, str) and value.startswith("inf")) else value

"""Fits of columns of numbers: counts per level, capacities, clouds of independent runs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.fit_options import FitOptions
from skewbridge.fragility.exchange.fit_tests import (
    with_lilliefors,
    with_normal_test,
    with_stripe_tests,
)
from skewbridge.fragility.old_likelihood.fit import FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.validate import as_column, as_list
from skewbridge.fragility.methods import cloud, cloud_models, ida, stripes, tobit
from skewbridge.reading import shortened

MOST_NAMED: Final = 20  # columns in a message
# Other spellings of the columns, as they stand in published data sets.
_ALIASES: Final = {
    "right_censored": "censored",
    "bracket_lo": "lower",
    "bracket_hi": "upper",
    "im_no_exceed": "lower",
    "im_exceed": "upper",
}


def fit_columns(data: Mapping[str, Any], options: FitOptions) -> FragilityFit:
    """Fit columns of numbers: stripes, capacities or brackets, or a cloud.

    Raises:
        InputError: A column is missing, a value unusable (names the row), or an option cannot be
            honoured for such data.
    """
    columns = {_ALIASES.get(str(key), str(key)): value for key, value in data.items()}

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
        if options.capacity_dispersion > 0.0:
            raise InputError(
                "--capacity-dispersion needs the demand of every run: a table of runs with --im, "
                "--edp and --threshold, not counts"
            )
        fit = stripes.fit_stripes(*counts, link=options.link, settings=options.settings)
        return with_stripe_tests(fit, *map(_numbers, counts)) if options.goodness else fit
    if options.method == "ida":
        if "lower" in columns or "upper" in columns:
            lower = need("lower")
            upper = [_endless(value) for value in as_list(need("upper"), "upper")]
            return ida.fit_brackets(lower, upper, options.settings)
        fit = ida.fit_capacities(need("capacity"), columns.get("censored"), options.settings)
        if not options.goodness or fit.exact is None:
            return fit
        return with_lilliefors(fit, np.log(_numbers(need("capacity"))))
    im = np.exp(as_column(columns["ln_im"], "ln_im")) if "ln_im" in columns else need("im")
    edp = np.exp(as_column(columns["ln_edp"], "ln_edp")) if "ln_edp" in columns else need("edp")
    threshold = options.threshold
    if threshold is None:
        given = np.atleast_1d(need("threshold"))[:1].tolist()
        if not given:
            raise InputError("the column threshold is empty: one number is needed")
        threshold = float(as_column(given, "threshold")[0])
    if "censored" in columns:
        if options.model not in (None, "tobit"):
            raise InputError(f"--model {options.model} cannot take censored demands: take tobit")
        return _fit_tobit(im, edp, threshold, columns["censored"], options)
    collapse = columns.get("collapse")
    flags = None if collapse is None else as_column(collapse, "collapse")
    return fit_cloud_columns(im, edp, threshold, flags, options)


def fit_cloud_columns(
    im: Any, edp: Any, threshold: float, collapse: FloatArray | None, options: FitOptions
) -> FragilityFit:
    """Fit a cloud of independent runs, of which ``collapse`` flags those that collapsed.

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    fallen = collapse is not None and bool(np.any(collapse > 0.0))
    trimmed = options.censor_above is not None or options.discard_below is not None
    model = options.model or ("tobit" if trimmed else "modified" if fallen else "ols")
    if model == "modified" and options.capacity_dispersion > 0.0:
        raise InputError("--capacity-dispersion with collapsed runs needs --model tobit or ols")
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
        if options.goodness:
            fit = with_normal_test(fit, np.log(x), np.log(d))
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


def _numbers(values: Any) -> FloatArray:
    return np.asarray(values, dtype=np.float64)


def _endless(value: Any) -> Any:
    """Read the text "inf" (JSON has no infinity) and null as an open end."""
    return None if value is None or (isinstance(value, str) and value.startswith("inf")) else value

"""Hazard curves of a site, from OpenQuake, the USGS or plain CSV, and annual rates from them.

The annual rate of a limit state is lambda = int P(x) |dH(x)| over the intensities of the hazard
curve H. ln H is linear in ln x between the points of the curve; nothing is extrapolated.

Sources: convolution, Cornell et al. (2002), J. Struct. Eng. 128(4):526-533; files, OpenQuake engine
manual (CSV exports: probabilities of exceedance in the investigation time; PGV in cm/s) and USGS
nshmp-haz (JSON and CSV: annual frequencies of exceedance).
"""

import csv
import logging
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.special import ndtri

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Row, as_column, positive, require
from skewbridge.files.text import (
    MAX_CSV_BYTES,
    file_fault,
    read_csv,
    read_json,
    read_text,
    shown_path,
)
from skewbridge.fragility.motion_means import Jackknifed, exp_end

logger = logging.getLogger(__name__)

#: Columns of intensities with hazard curves, in the order in which a study prefers them.
PREFERRED: Final = (
    "im_saavg_rotd50_g", "im_sa_t1_rotd50_g", "im_sa_1p000_rotd50_g", "im_pga_rotd50_g",
    "im_pgv_rotd50_mps",
)  # fmt: skip
_NAMES: Final = {
    "PGA": PREFERRED[3], "PGV": PREFERRED[4], "AVGSA": PREFERRED[0], "SA_AVG": PREFERRED[0],
    "SA(T1)": PREFERRED[1],
}  # fmt: skip
_FACTORS: Final = {"g": 1.0, "m/s": 1.0, "cm/s": 0.01}  # to the unit of the column
_UNIT: Final = re.compile(r"(.*?)\s*[(\[](g|m/s|cm/s)[)\]]$")
_FRACTILE: Final = re.compile(r"rate_p(\d+(?:\.\d+)?)$")
#: ASSUME no curve reaches 20 g or 20 m/s: more is another unit
_LARGEST_LEVEL: Final = 20.0
# ASSUME no site exceeds 0.2 g or 0.2 m/s more often than 0.15 times a year, and a hazard curve
# reaches rates below 0.01 per year; a column that does not has probabilities
_STRONG, _LARGEST_RATE, _LAST_RATE = 0.2, 0.15, 0.01
_LEAST_RATE: Final = 1e-15  # 1/year; replaces zero rates of fractile curves
#: Range of ln im below the first intensity in which a rate may lack a part.
BELOW: Final = float(np.log(10.0))
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)


class LogRate(NamedTuple):
    """ln of an annual rate, or of a ratio of rates."""

    logs: Floats  # from all runs, then without each block, shape (R,)
    fractiles: Floats  # from all runs, with the fractiles of the hazard, shape (F,)
    quantiles: Floats  # probability of each fractile curve, shape (F,)
    priors: int = 0  # number of last ``logs`` that are errors from priors, not without a block

    @property
    def value(self) -> float:
        """The rate or ratio from all runs."""
        return float(np.exp(self.logs[0]))

    def interval(
        self, level: float, factors: tuple[float, float] | None = None
    ) -> tuple[float, float, float]:
        """Return the estimate and both interval ends, which cover motions and hazard together.

        ``factors`` give the interval of the motions; without them it is from the jackknife.
        """
        estimate, jackknifed = self.logs[0], Jackknifed.of_replicates(self.logs, self.priors)
        interval = np.array(estimate + np.log(factors) if factors else jackknifed.interval(level))
        if self.fractiles.size > 1:
            signs, ends = np.array([-1.0, 1.0]), _hazard_ends(self.fractiles, self.quantiles, level)
            widths = np.maximum(signs * (ends - estimate), 0.0)
            interval = estimate + signs * np.hypot(interval - estimate, widths)
        return exp_end(estimate), exp_end(float(interval[0])), exp_end(float(interval[1]))

    def minus(self, other: "LogRate") -> "LogRate":
        """Return ln of the ratio to another rate from the same motions and hazard."""
        fractiles = self.fractiles - other.fractiles
        return self._replace(logs=self.logs - other.logs, fractiles=fractiles)


def _hazard_ends(ln_rates: Floats, quantiles: Floats, level: float) -> Floats:
    """Return the ends (2,) of the interval of an ln rate from its values by fractiles (F,)."""
    # ASSUME the uncertain hazard is lognormal, and its curves do not cross
    sigma, middle = np.polyfit(ndtri(quantiles), ln_rates, 1)
    return middle + abs(sigma) * ndtri(0.5 + 0.5 * level) * np.array([-1.0, 1.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class HazardCurve:
    """Annual rates of exceedance at n intensities: mean (or median), then F fractiles."""

    im: str  # column of the intensity; empty: not named by the file
    levels: Floats  # in the unit of the column, shape (n,)
    rates: Floats  # 1/year, shape (1 + F, n)
    quantiles: Floats  # probability of each fractile, shape (F,)
    source: str = ""  # name of the file

    @property
    def doubt(self) -> str:
        """Sentence if the rates look like probabilities in many years, or an empty text."""
        mean, at = self.rates[0], int(np.searchsorted(self.levels, _STRONG))
        # several probabilities near one, and none above it
        is_flat = mean[0] <= 1.0 and int(np.sum(mean > 0.9)) > 2
        is_high = at < mean.size and mean[at] > _LARGEST_RATE
        if not (is_flat or is_high or mean[-1] >= _LAST_RATE):
            return ""
        at = 0 if is_flat else at if is_high else -1
        text = f"{mean[at]:.3g} per year at {self.levels[at]:.3g} looks like a probability"
        return f"{self.source}: {text} in many years: rate = -ln(1 - P) / years"

    @property
    def depends_on_t1(self) -> bool:
        """Whether the intensity is Sa_avg or Sa(T1), which differ between bridges."""
        return self.im in PREFERRED[:2]

    def rate(self, probability: Callable[[Floats], Floats], narrowest: float) -> LogRate:
        """Return the ln annual rates of R fragility curves, integrated over the hazard.

        ``probability`` maps ln im (k, 1) to P(exceeds) of the curves (k, R). ``narrowest``, the
        smallest dispersion of the curves, limits the width of the integration panels.
        """
        ln_im, weights = self._nodes(narrowest)
        return self.logs_of(weights @ probability(ln_im[:, None]))

    def rate_of_failures(self, ln_failures: Floats) -> LogRate:
        """Return ln rates of R systems, each from n equally likely ln intensities of failure."""
        # int P |dH| = E[H(x)] - H(last), where H is constant outside the curve
        x, logs = np.log(self.levels), np.log(self.rates)
        means = [np.mean(np.exp(np.interp(ln_failures, x, row)), axis=1) for row in logs]
        return self.logs_of(np.array(means) - self.rates[:, -1:])

    def logs_of(self, rates: Floats) -> LogRate:
        """Return the logarithms of rates (1 + F, R) by the mean hazard curve, then F fractiles."""
        logs = np.log(np.maximum(rates, np.finfo(np.float64).tiny))
        return LogRate(logs[0], logs[1:, 0], self.quantiles)

    def highest_rate(self, level: float) -> float:
        """Return the rate of the lowest intensity: the upper end of its interval by fractiles."""
        rate, *fractiles = np.log(self.rates[:, 0])
        if self.quantiles.size > 1:
            rate = max(rate, _hazard_ends(np.array(fractiles), self.quantiles, level)[1])
        return float(np.exp(rate))

    def shares(
        self, rate: Callable[["HazardCurve"], LogRate], p_last: float, low: float, high: float
    ) -> Row:
        """Return columns with shares of a rate: outside the hazard curve (bounds), extrapolated.

        ``rate`` returns the ln rate of a state for a hazard curve; ``p_last`` is P(exceeds) at
        the last intensity. Intensities outside ``low`` to ``high`` count as extrapolated.
        """
        # ASSUME hazard curves flatten towards weak intensities: the first slope gives a bound
        slope = np.diff(np.log(self.rates[:, :2]))[:, 0] / np.diff(np.log(self.levels[:2]))
        first_rates = self.rates[:, 0] * np.exp(-BELOW * slope)
        extended = replace(
            self,
            levels=np.append(np.exp(-BELOW) * self.levels[0], self.levels),
            rates=np.column_stack([first_rates, self.rates]),
        )
        all_rate, last_rate = rate(self).value, float(self.rates[0, -1])
        covered = self._between(low, high)
        covered_rate = covered and rate(covered).value
        row: Row = {
            f"share_outside_{end}": extra / (all_rate + extra)
            for end, extra in (("low", p_last * last_rate), ("high", last_rate))
        }
        row["share_below"] = max(0.0, 1.0 - all_rate / rate(extended).value)
        return row | {"share_extrapolated": max(0.0, 1.0 - (covered_rate or 0.0) / all_rate)}

    def _between(self, low: float, high: float) -> "HazardCurve | None":
        """Return the part of the curve between two intensities; None if it is empty."""
        x = self.levels
        inner_points = x[(x > low) & (x < high)]
        points = np.unique([*np.clip([low, high], x[0], x[-1]), *inner_points])
        if not low < high or points.size < 2:
            return None
        logs = [np.interp(np.log(points), np.log(x), row) for row in np.log(self.rates)]
        return replace(self, levels=points, rates=np.exp(logs))

    def _nodes(self, narrowest: float) -> tuple[Floats, Floats]:
        """Return ln im (k,) and weights -dH (1 + F, k) of a Gauss-Legendre rule in ln im."""
        x, ln_rate = np.log(self.levels), np.log(self.rates)
        steps, slope = np.diff(x), -np.diff(ln_rate) / np.diff(x)
        # panels as wide as the dispersion at most, over which H falls by a factor of exp(4) at most
        count = np.ceil(np.maximum(steps / narrowest, steps * np.max(slope, axis=0) / 4.0))
        count = np.clip(count, 1, 400).astype(np.intp)
        segment = np.repeat(np.arange(steps.size), count)
        panel = np.arange(segment.size) - np.repeat(np.cumsum(count) - count, count)
        width = (steps / count)[segment]
        dx = (panel[:, None] + 0.5 * (1.0 + _NODES)) * width[:, None]
        decay = slope[:, segment, None]
        weights = decay * np.exp(ln_rate[:, segment, None] - decay * dx) * width[:, None] * _WEIGHTS
        return (x[segment, None] + dx).ravel(), 0.5 * weights.reshape(len(ln_rate), -1)


def measure_column(name: str) -> str:
    """Return the column of an intensity measure such as PGA, SA(1.0), SA1P0 or AvgSA; else ''."""
    text = name.strip()
    if text.startswith("im_"):
        return text
    if match := re.fullmatch(r"(?i)SA\s*\(?(\d+(?:[.P]\d+)?)(?: ?s)?\)?", text):
        period = f"{float(match[1].upper().replace('P', '.')):.3f}"
        return f"im_sa_{period.replace('.', 'p')}_rotd50_g"
    return _NAMES.get(text.upper(), "")


def _usual_factor(column: str) -> float:
    """Return the factor that converts levels of OpenQuake or nshmp-haz to the unit of a column."""
    return _FACTORS["cm/s" if column == _NAMES["PGV"] else "g"]


class _Part(NamedTuple):
    """Mean or fractile curve in a file: annual rates at levels of the measure ``im``."""

    im: str
    quantile: float | None  # None: mean
    levels: Floats
    rates: Floats


def hazard_curve(
    file: Path | None, measures: Sequence[str], default: str, *, warns: bool = True
) -> HazardCurve | None:
    """Return the hazard curve of a file for one of ``measures``; None without a file.

    ``default`` is taken if the file has it or names no measure; ``warns`` logs the `doubt` of the
    curve. An `InputError` names the file.
    """
    if file is None:
        return None
    curves = {curve.im: curve for curve in read_hazard(file)}
    names = [name or "an intensity im without a measure" for name in curves]
    if "" in curves:
        curves = {default: replace(curves[""], im=default)}
    order = [default, *PREFERRED]
    measure = next((name for name in order if name in curves and name in measures), None)
    if measure is None:
        in_file, in_study = (", ".join(texts) for texts in (names, measures))
        text = f": no hazard curve fits the study. The file has {in_file}; "
        text += f"give the hazard of a measure of the study: {in_study}"
        raise file_fault(file, f"{text}. SA at T1 of the bridge is named SA(T1)")
    if warns and (doubt := curves[measure].doubt):
        logger.warning("%s", doubt)
    return curves[measure]


def read_hazard(path: Path) -> list[HazardCurve]:
    """Return the hazard curves of a file, or of all files in a folder, one per measure."""
    files = [path]
    if path.is_dir():
        files = sorted(f for f in path.iterdir() if f.suffix.lower() in (".csv", ".json"))
        # OpenQuake also exports maps, spectra and realizations to this folder
        files = [f for f in files if re.search("_curve-mean|quantile_curve-", f.name)] or files
    if not files:
        raise file_fault(path, " has no hazard curve (.csv or .json file)")
    groups: dict[str, dict[float | None, _Part]] = defaultdict(dict)
    for file in files:
        try:
            for curve in _parts(file):
                if curve.quantile in groups[curve.im]:
                    raise InputError(f"two curves of {curve.im or 'one measure'}: keep one")
                groups[curve.im][curve.quantile] = curve
        except InputError as error:
            names_file = shown_path(file) in str(error)
            raise error if names_file else file_fault(file, f": {error}", **error.details) from None
        except (AttributeError, LookupError, TypeError, ValueError):
            raise file_fault(file, " is not a hazard curve in a known format") from None
    if not groups:
        raise file_fault(path, " has no hazard curve that this version can read")
    return [_assembled(path, parts) for parts in groups.values()]


def _assembled(path: Path, parts: dict[float | None, _Part]) -> HazardCurve:
    mean = parts.get(None, parts.get(0.5))
    if mean is None:
        im = next(iter(parts.values())).im
        raise file_fault(path, f": {im} has fractiles only: add its mean or median curve")
    quantiles = sorted(q for q in parts if q is not None)
    if len(quantiles) == 1 and parts.keys() - {None, 0.5}:
        fractile = f"one fractile ({100.0 * quantiles[0]:g} %)"
        raise file_fault(path, f": {fractile} gives no interval: add another one, or remove it")
    curves = [mean, *(parts[q] for q in quantiles)]
    if any(not np.array_equal(curve.levels, mean.levels) for curve in curves):
        raise file_fault(path, f": fractiles of {mean.im} must have the intensities of the mean")
    rates = np.array([curve.rates for curve in curves])
    if np.any(rates[2:] < 0.999 * rates[1:-1]):  # more than rounding
        raise file_fault(path, f": the rates of {mean.im} must grow with the fractile")
    # a probability of one in the investigation time has no rate; zero rates end the curve
    is_usable = np.all(np.isfinite(rates), axis=0) & (rates[0] > 0.0)
    if np.sum(is_usable) < 2:
        raise file_fault(path, ": at least two intensities must have a rate above zero")
    positive_rates = np.maximum(rates[:, is_usable], _LEAST_RATE)
    arrays = {"levels": mean.levels[is_usable], "rates": positive_rates}
    return HazardCurve(im=mean.im, quantiles=np.array(quantiles), source=path.name, **arrays)


def _parts(path: Path) -> Iterator[_Part]:
    if path.suffix.lower() == ".json":
        curves = _usgs_json(path)
    else:
        first_line = read_text(path, MAX_CSV_BYTES).lstrip().partition("\n")[0]
        curves = _openquake(path, first_line) if first_line.startswith("#") else _table(path)
    for curve in curves:
        if not 0.0 < (0.5 if curve.quantile is None else curve.quantile) < 1.0:
            raise InputError(f"a fractile must be above 0 and below 1, got {curve.quantile:g}")
        levels = positive(curve.levels, "im")
        rates = as_column(curve.rates, "rate")
        if levels.size != rates.size:
            raise InputError(f"there are {levels.size} intensities and {rates.size} rates")
        if (np.diff(levels) < 0.0).all():
            levels, rates = levels[::-1], rates[::-1]
        require(~np.isnan(rates), "rate", "is not a number", rates)
        require(~(rates < 0.0), "rate", "must not be negative", rates)
        rule = f"must be at most {_LARGEST_LEVEL:g} g or m/s"
        require(levels <= _LARGEST_LEVEL, "im", rule, levels)
        require(np.append(True, np.diff(levels) > 0.0), "im", "must increase", levels)
        with np.errstate(invalid="ignore"):  # inf - inf
            grows = np.append(False, np.diff(rates) > 0.0)
        require(~grows, "rate", "must not increase with the intensity", rates)
        yield curve._replace(levels=levels, rates=rates)


def _openquake(path: Path, first_line: str) -> Iterator[_Part]:
    entries = dict(re.findall(r"(\w+)='?([^,'\"]+)", first_line))
    missing = [name for name in ("kind", "imt", "investigation_time") if name not in entries]
    if missing:
        raise InputError(f"the first line of an OpenQuake file must give {', '.join(missing)}")
    _, header, *sites = csv.reader(read_text(path, MAX_CSV_BYTES).strip().splitlines())
    if len(sites) != 1:
        raise InputError(f"has the hazard of {len(sites)} sites: keep the line of one site")
    values = {n: p for n, p in zip(header, sites[0], strict=False) if n.startswith("poe-")}
    levels = as_column([name.removeprefix("poe-") for name in values], "poe")
    poe = as_column(list(values.values()), "poe")
    require((poe >= 0.0) & (poe <= 1.0), "poe", "must be within 0..1", poe)
    column, kind = measure_column(entries["imt"]), entries["kind"]
    with np.errstate(divide="ignore"):
        rates = -np.log1p(-poe) / float(entries["investigation_time"])
    quantile = None if kind == "mean" else float(kind.removeprefix("quantile-"))
    yield _Part(column or entries["imt"], quantile, _usual_factor(column) * levels, rates)


def _table(path: Path) -> Iterator[_Part]:
    """Yield the curves of a CSV file: columns of intensity, rate, fractiles, or USGS (one site)."""
    table = read_csv(path).rename(columns=str.strip).rename(columns={"IM": "im", "Rate": "rate"})
    names = list(map(str, table))
    if {"lon", "lat"} <= {*names}:
        if len(table) != 1:
            raise InputError(f"has the hazard of {len(table)} sites: keep the line of one site")
        columns = [name for name in names if re.fullmatch(r"[\d.eE+-]+", name)]
        name = next(filter(None, map(measure_column, (path.stem, path.parent.name))), "")
        if not name:
            raise InputError("name the file or its folder after the measure, such as SA1P0.csv")
        # source: nshmp-haz writes accelerations in g and velocities in cm/s
        levels = _usual_factor(name) * as_column(columns, "im")
        yield _Part(name, None, levels, table.loc[0, columns].to_numpy(dtype=np.float64))
        return
    if len(names) < 2 or names[1] != "rate":
        text = "the columns must be an intensity (im, or a measure with its unit), rate"
        text = f"{text} and fractiles such as rate_p16; got {', '.join(names[:5])}"
        advice = "Rate: 1 / return period, or -ln(1 - P) / years of a probability P"
        raise InputError(f"{text}. {advice}")
    column, factor = _measure_and_factor(names[0])
    for name in names[1:]:
        match = _FRACTILE.fullmatch(name)
        if name != "rate" and not match:
            raise InputError(f"the column {name!r} is not a fractile such as rate_p16")
        quantile = float(match[1]) / 100.0 if match else None
        levels = factor * as_column(table[names[0]], "im")
        yield _Part(column, quantile, levels, as_column(table[name], "rate"))


def _measure_and_factor(title: str) -> tuple[str, float]:
    """Return the column of the measure in a heading ('' for ``im``), and the factor to its unit."""
    if title == "im" or title.startswith("im_"):
        return title.removesuffix("im"), 1.0
    match = _UNIT.fullmatch(title)
    column = measure_column(match[1] if match else title)
    if not column:
        example = "SA(1.0) (g), Sa_avg (g) or PGV (cm/s); units: g, m/s, cm/s"
        raise InputError(f"{title!r} is not a measure with its unit, such as {example}")
    if not match:
        unit = "cm/s" if column == _NAMES["PGV"] else "g"
        raise InputError(f"the unit of {title} is missing: write {title} ({unit})")
    if (match[2] == "g") == (column == _NAMES["PGV"]):
        raise InputError(f"{match[1]} cannot have the unit {match[2]}: write g, or cm/s for PGV")
    return column, _FACTORS[match[2]]


def _usgs_json(path: Path) -> Iterator[_Part]:
    content = read_json(path)
    response = content.get("response", content) if isinstance(content, dict) else content
    common: Any = {}
    if isinstance(response, dict):
        common = response.get("metadata", {})
        response = response.get("hazardCurves", [])
    for entry in response if isinstance(response, list) else []:
        metadata = {**common, **entry.get("metadata", {}), **entry}
        imt = metadata.get("imt", {})
        name = str(imt.get("value", imt) if isinstance(imt, dict) else imt)
        unit = re.search(r"\((g|m/s|cm/s)\)", f"{imt} {metadata.get('xlabel', '')}")
        if not unit:
            raise InputError(f"the unit of {name} is missing: xlabel must end with it, as (g)")
        totals = [curve for curve in entry.get("data", []) if curve.get("component") == "Total"]
        if len(totals) != 1:
            text = f"{name} must have one curve of the component Total"
            raise InputError(f"{text}, got {len(totals)}")
        values = totals[0].get("values", {})
        levels = values.get("xs", metadata.get("xvalues"))
        rates = values.get("ys", totals[0].get("yvalues"))
        levels = _FACTORS[unit[1]] * as_column(levels, f"{name} xs")
        yield _Part(measure_column(name) or name, None, levels, as_column(rates, f"{name} ys"))

"""What a fit knows beside its median and dispersion, one typed part for each kind of result."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isnan, nan
from typing import Any, Literal

type Ends = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Further results of a fit; a value that a method does not give is None."""

    def as_json(self) -> dict[str, Any]:
        """Return the values that are there, by name."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class LineFit(Part):
    """Line of ln demand on ln intensity; by least squares, with the tests of its assumptions.

    Attributes:
        ln_a: Intercept.
        b: Slope.
        sigma: Scatter of ln demand about the line.
        n: Runs of a least-squares line, else 0 and the rest is NaN.
        mean_x: Mean of ln x.
        sxx: Sum of squares of ln x about its mean.
        r2: Coefficient of determination.
        curvature: Coefficient of (ln x - mean)^2 when it is added.
        curvature_p: p-value of its F test (exact, one degree of freedom).
        scatter_p: p-value of the studentised Breusch-Pagan test of constant scatter.
        cook_max: Largest Cook's distance.
        normal_p: p-value of Lilliefors' test of the residuals, where it was asked for.
    """

    ln_a: float = nan
    b: float = nan
    sigma: float = nan
    n: int = 0
    mean_x: float = nan
    sxx: float = nan
    r2: float = nan
    curvature: float = nan
    curvature_p: float = nan
    scatter_p: float = nan
    cook_max: float = nan
    normal_p: float = nan

    def as_json(self) -> dict[str, Any]:
        """Return the line, and its tests where there are any."""
        names = ("ln_a", "b") if isnan(self.sigma) else ("ln_a", "b", "sigma")
        tests = ("r2", "curvature", "curvature_p", "scatter_p", "cook_max") if self.n else ()
        asked = () if isnan(self.normal_p) else ("normal_p",)
        return {name: getattr(self, name) for name in (*names, *tests, *asked)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Predictor(Part):
    """Linear predictor eta = a0 + a1 ln x of the probability of exceedance, and its link.

    ``mu`` is the mean of ln capacity (fits to capacities), ``beta_equiv_pi_sqrt3`` the standard
    deviation of the logistic distribution (logit link).
    """

    a0: float | None = None
    a1: float | None = None
    link: str | None = None
    mu: float | None = None
    beta_equiv_pi_sqrt3: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Goodness(Part):
    """Goodness of a fit to stripes.

    Deviance with degrees of freedom and chi-square p-value (None for single runs, where the
    deviance says nothing about the fit; it holds for expected counts of 1 or more), p-value of the
    score test of a curvature (square of ln intensity) in the predictor, Pearson's statistic,
    log-likelihood without binomial coefficients, Akaike's criterion.
    """

    deviance: float
    deviance_dof: int
    deviance_p: float | None
    link_p: float | None
    pearson: float
    loglik_kernel: float
    aic: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedTests(Part):
    """Tests of a fit whose p-values are shares of simulated samples.

    Deviance of stripes; likelihood ratio of any increasing curve to the fitted one; Lilliefors'
    distance of residuals or ln capacities with its critical values at 5 and 10 %.
    """

    deviance_p_simulated: float | None = None
    isotonic_lr: float | None = None
    isotonic_p: float | None = None
    lilliefors_d: float | None = None
    lilliefors_d_05: float | None = None
    lilliefors_d_10: float | None = None
    lilliefors_p: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MedianBound(Part):
    """One-sided bound of the median where no run exceeds (lower) or every run does (upper).

    Attributes:
        side: Which bound.
        level: Its confidence.
        theta_given_beta: Bound by assumed dispersion.
        assumed_beta: The dispersion of the headline bound.
    """

    side: Literal["lower", "upper"]
    level: float
    theta_given_beta: Mapping[float, float]
    assumed_beta: float | None = None

    @property
    def headline(self) -> tuple[float, float]:
        """The bound for the assumed dispersion, and that dispersion; NaN if none is assumed."""
        beta = nan if self.assumed_beta is None else self.assumed_beta
        return self.theta_given_beta.get(beta, nan), beta

    def as_json(self) -> dict[str, Any]:
        """Return the bounds under the name of their side and level."""
        name = f"theta_{self.side}{100 * self.level:g}_given_beta"
        bounds = {f"{beta:g}": theta for beta, theta in self.theta_given_beta.items()}
        known = {} if self.assumed_beta is None else {"assumed_beta": self.assumed_beta}
        return known | {name: bounds}


@dataclass(frozen=True, slots=True, kw_only=True)
class Separation(Part):
    """What separated data still say.

    Attributes:
        theta_interval: Largest level without, smallest level with exceedance.
        theta_midpoint_log: Their geometric mean.
        theta_bounds_given_beta: One-sided lower and upper bound of the median, by assumed
            dispersion.
        firth: Penalised ``theta`` and ``beta``, not the maximum likelihood.
    """

    theta_interval: Ends
    theta_midpoint_log: float | None = None
    theta_bounds_given_beta: Mapping[str, Ends] | None = None
    firth: Mapping[str, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Proportions(Part):
    """Proportions of exceedance where no curve can be fitted.

    Clopper-Pearson limits per stripe; at a single level also the proportion, its interval and the
    median that it implies, by assumed dispersion.
    """

    p_lower: tuple[float, ...]
    p_upper: tuple[float, ...]
    p: float | None = None
    p_ci: Ends | None = None
    theta_given_beta: Mapping[str, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactIntervals(Part):
    """Unbiased dispersion of a complete sample of capacities, t and chi-square intervals."""

    beta_unbiased_n_minus_1: float
    ci_theta_exact: Ends
    ci_beta_exact: Ends


@dataclass(frozen=True, slots=True, kw_only=True)
class CollapseFit(Part):
    """Collapse curve of the modified cloud: runs that collapsed, linear predictor and link.

    ``part`` names the half (``collapse`` or ``demand``) that could not be fitted.
    """

    part: str | None = None
    n_collapse: int | None = None
    collapse_a0: float | None = None
    collapse_a1: float | None = None
    collapse_link: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ScatterTrend(Part):
    """Scatter ln sigma(x) = g0 + g1 ln x, with the likelihood-ratio test of g1 = 0."""

    g0: float
    g1: float
    loglik_homoscedastic: float
    lr: float
    lr_p: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoints(Part):
    """Points of a curve that is not lognormal: its quantiles and a short table."""

    x16: float
    x50: float
    x84: float
    curve_im: tuple[float, ...]
    curve_p: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RunCounts(Part):
    """Runs and records behind a fit, with median and dispersion by treatment of unknown outcomes.

    Censored demands or capacities, records that exceed and at a stronger level no longer do,
    motions, and runs whose outcome is unknown.
    """

    n_censored: int | None = None
    n_non_monotone: int | None = None
    n_records: int | None = None
    n_unknown: int | None = None
    bounds: Mapping[str, float] | None = None

"""System fragility of variants: at least one component reaches a degree of damage.

Component i fails at ln x_i = ln theta_i + beta_i e_i, with correlated standard normal e_i. The
system fails at the smallest of these intensities. The system curve is the distribution of this
intensity over quasi-random e. A component with several failure modes fails in the first of them.

Sources: component demands as joint lognormals, Nielson and DesRoches (2007), EESD 36(6):823-839;
scrambled Sobol points, Owen (1998), J. Complexity 14(4):466-489.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from itertools import combinations
from math import inf, nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row, records_of
from skewbridge.fragility import demand_table, fits
from skewbridge.fragility.demand_model import TOO_FEW_RUNS, BridgeModels, StateCurve
from skewbridge.fragility.hazard import BELOW, HazardCurve
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.motion_means import Jackknifed, covered_range, exp_end
from skewbridge.fragility.outcomes import DemandOutcomes, demand_outcomes
from skewbridge.fragility.settings import ASSUMED_BETA, DEFAULTS, FitSettings
from skewbridge.fragility.union import MIN_COMPLETE

#: Smallest number of runs of a variant for a system curve; components need MIN_COMPLETE.
MIN_RUNS: Final = 8
_EVERYWHERE: Final = "exceeded in every run"  # then the system is, too
_POINTS: Final = 2**13  # error of the median of the system below 0.1 %
_POINTS_OF_REPLICATES: Final = 2**11
_SEED: Final = 20261120  # any: the median has the same error for all seeds


def system_curves(
    models: Iterable[BridgeModels],
    limit_states: States,
    settings: FitSettings = DEFAULTS,
    *,
    curves: pd.DataFrame | None = None,  # whose withheld curves limit the system
    hazard: HazardCurve | None = None,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the table `system`: one row per variant and degree of damage.

    A component is included if some runs of the variant, but not all, exceed its state and its
    demand increases with intensity; if all runs exceed it, they exceed the system, which has only a
    bound. Only variants with equal ``components`` can be compared. The column ``withheld`` names
    the components that have no curve in ``curves`` because of unknown outcomes; there is no system
    curve if these change its median too much. An `InputError` names a degree of damage that
    components rank differently. With a hazard, the columns `rate` (a `LogRate`) and `shares` are
    added.
    """
    members = system_members([state for state in limit_states if state.system_degree])
    withheld: Mapping[Any, float] = {}
    if curves is not None:
        lost = curves[(curves["method"] == "cloud") & (curves["status"] == fits.BOUNDS_TOO_WIDE)]
        keys = ["variant", "component", "limit_state"]
        withheld = lost.set_index(keys)["theta_all_exceed"].astype(float).to_dict()
    systems = [_Systems(system, members, settings, hazard, withheld) for system in models]
    rows = demand_table.spread(_rows, systems, jobs, alone_s=0.0)
    return pd.DataFrame([row for of_bridge in rows for row in of_bridge])


def difference(first: Row, second: Row) -> str:
    """Return the components that only one of two rows of `system` has; empty if there is none."""
    names = [set(filter(None, row["components"].split(";"))) for row in (first, second)]
    extras = zip((first, second), (names[0] - names[1], names[1] - names[0]), strict=True)
    texts = [f"only {row['variant']}: {', '.join(sorted(extra))}" for row, extra in extras if extra]
    return "; ".join(texts)


def averaged(pairs: Sequence[Sequence[Row]]) -> list[bool]:
    """Return which pairs of systems a mean over pairs includes.

    The systems of a pair must have the same components, and all pairs of a mean those of most
    pairs; of equally many pairs, those with more components.
    """
    names = ["" if difference(*pair) else pair[0]["components"] for pair in pairs]
    rank = {name: (names.count(name), name.count(";")) for name in filter(None, names)}
    most_common = max(rank, key=rank.__getitem__, default=None)
    return [name == most_common for name in names]


def system_members(states: States) -> dict[str, list[LimitState]]:
    """Return the component states in the system for each degree of damage, from mild to severe.

    For each degree, each component has its mildest state of this or a more severe degree. A degree
    is more severe than another if it comes later in some component.
    """
    by_component: dict[str, list[LimitState]] = {state.component: [] for state in states}
    for state in sorted(states, key=lambda item: item.threshold):
        by_component[state.component].append(state)
    degrees = list(dict.fromkeys(state.system_degree for state in states))
    severer: dict[str, set[str]] = {name: set() for name in degrees}
    for _ in degrees:  # transitive closure
        for ordered in by_component.values():
            for mild, severe in combinations([state.system_degree for state in ordered], 2):
                severer[mild] |= {severe} | severer[severe]
    if inconsistent := [name for name in degrees if name in severer[name]]:
        text = f"components rank the damage degree {inconsistent[0]!r} differently"
        raise InputError(f"{text}: give all components the same order of degrees")
    members: dict[str, list[LimitState]] = {}
    for degree in sorted(degrees, key=lambda name: -len(severer[name])):
        enough = {degree} | severer[degree]
        by_severity = [[s for s in c if s.system_degree in enough] for c in by_component.values()]
        members[degree] = [severe[0] for severe in by_severity if severe]
    return members


class _Member(NamedTuple):
    """A component of the system; its R curves are from all runs, then without each event."""

    state: LimitState
    outcomes: DemandOutcomes  # of the runs of the variant
    curve: StateCurve
    lowest: float  # median if all unknown outcomes exceed, for a withheld curve; else infinite


class _Systems(NamedTuple):
    """Members of the systems of one bridge for each degree of damage."""

    models: BridgeModels
    members: Mapping[str, States]
    settings: FitSettings
    hazard: HazardCurve | None
    #: median if all unknown outcomes exceed, of withheld curves by variant, component and state
    withheld: Mapping[Any, float]


def _rows(systems: _Systems) -> list[Row]:
    variants = range(len(systems.models.variants))
    return [row for number in variants for row in _variant_rows(systems, number)]


def _variant_rows(systems: _Systems, variant_number: int) -> list[Row]:
    models, settings = systems.models, systems.settings
    values = records_of(models.variants)[variant_number]
    runs = models.runs[models.variant == variant_number]
    im = runs[settings.im].to_numpy(dtype=np.float64)
    low, high = covered_range(im, demand_table.motion_codes(runs))
    variant = demand_table.variant_values(runs)

    @cache
    def member(state: LimitState) -> _Member | str:
        """Return a component with its curves, or the reason why it is left out."""
        fit = models.fit(state)
        outcomes = demand_outcomes(runs, [state])
        if fit == TOO_FEW_RUNS or np.sum(outcomes.complete & outcomes.used) < MIN_COMPLETE:
            return "too few complete runs"
        if (status := outcomes.status(state)) != fits.FITTED:
            return {fits.NO_EXCEEDANCE: "not reached", fits.ALL_EXCEED: _EVERYWHERE}[status]
        curve = models.curve(state, values)
        if isinstance(curve, str):
            return "demand does not grow"
        lowest = systems.withheld.get((variant["variant"], state.component, state.name), inf)
        return _Member(state, outcomes, curve, lowest)

    rows: list[Row] = []
    for degree, states in systems.members.items():
        members: list[_Member] = []
        names: list[str] = []
        left_out: list[str] = []
        everywhere = np.zeros(len(runs), dtype=np.bool_)
        for state in states:
            modes = [member(mode) for mode in state.modes or (state,)]
            if _EVERYWHERE in modes:
                everywhere |= demand_outcomes(runs, [state]).exceed(state)
            usable = [mode for mode in modes if isinstance(mode, _Member)]
            reasons = dict.fromkeys(mode for mode in modes if isinstance(mode, str))
            if usable:
                names.append(_member_name(state, degree, [mode.state for mode in usable]))
                reasons.pop("not reached", None)  # another mode is
            members += usable
            left_out += [f"{state.component}: {reason}" for reason in reasons]
        row = {name: nan for name in demand_table.described("system") if name not in variant}
        row |= {"limit_state": degree, "weakest": ""}
        row |= {"components": ";".join(names), "left_out": ";".join(left_out)}
        row |= {"level": settings.confidence, "n_runs": len(runs), "im_low": low, "im_high": high}
        withheld = (item.state.component for item in members if item.lowest != inf)
        row["withheld"] = ";".join(dict.fromkeys(withheld))
        row |= _system(members, np.log(im), systems, (low, high), everywhere)
        theta = row["theta"]
        is_outside = isinstance(theta, float) and not (np.isnan(theta) or low <= theta <= high)
        rows.append(variant | row | {"extrapolated": is_outside})
    return rows


def _member_name(state: LimitState, degree: str, modes: States) -> str:
    """Return ``component (state: modes)``; state if not ``degree``, modes if some are left out."""
    name = "" if state.name == degree else state.name
    if len(modes) < len(state.modes):
        name = f"{state.name}: {', '.join(mode.name for mode in modes)}"
    return f"{state.component} ({name})" if name else state.component


def _system(
    members: Sequence[_Member],
    ln_im: Floats,
    systems: _Systems,
    covered: tuple[float, float],
    exceeded_by_all: Mask,  # runs that exceed a component that every known run exceeds, (n,)
) -> Row:
    """Return the table columns of one system: the estimate, or a status if there is none."""
    settings = systems.settings
    exceed = np.logical_or.reduce([exceeded_by_all, *(m.outcomes.exceed(m.state) for m in members)])
    all_exceed = np.full(ln_im.size, np.any(exceeded_by_all))
    unknown = np.logical_or.reduce([all_exceed, *(m.outcomes.unknown(m.state) for m in members)])
    unknown &= ~exceed
    row: Row = {"n_exceed": int(exceed.sum()), "n_unknown": int(unknown.sum())}
    if not (members or np.any(exceeded_by_all)) or ln_im.size < MIN_RUNS:
        return row | {"status": "too_few_runs" if members else "no_component"}
    if np.all(exceed | unknown):
        ones, beta, level = np.ones(exceed.sum()), ASSUMED_BETA, settings.confidence
        bound = fits.median_bound(ln_im[exceed], ones, beta=beta, level=level, exceed=True)
        return row | {"status": fits.ALL_EXCEED, "theta_bound": bound}
    curves = [member.curve for member in members]
    priors = curves[0].priors
    ln_theta = np.column_stack([curve.ln_theta for curve in curves])
    records = np.column_stack([curve.beta for curve in curves])
    beta = np.column_stack([curve.total for curve in curves])
    # ASSUME component capacities are independent of each other and of the demands
    share = np.divide(records, beta, out=np.zeros_like(beta), where=beta > 0.0)
    correlation = _correlation(members, systems) * share[:, :, None] * share[:, None, :]
    size = len(members)
    correlation[:, np.arange(size), np.arange(size)] = 1.0
    of_all_runs = ln_theta[:1], beta[:1]
    failures = _failures(*of_all_runs, correlation[:1], _POINTS)
    ln_median, dispersion = _quantiles(failures)[:, 0]
    lowest = np.array([member.lowest for member in members])
    if np.any(lowest != inf):
        # the system if all unknown outcomes exceed, and without the components in doubt
        most = failures + np.minimum(np.log(lowest) - ln_theta[0], 0.0)[:, None, None]
        ends = [_quantiles(part)[0, 0] for part in (most, failures[lowest == inf]) if len(part)]
        if len(ends) < 2 or not ends[1] - ends[0] <= np.log(fits.MAX_BOUNDS_RATIO):
            return row | {"status": fits.BOUNDS_TOO_WIDE}
    first = np.min(failures[:, 0], axis=0)
    empirical = (np.arange(_POINTS) + 0.5) / _POINTS
    distance = np.abs(special.ndtr((np.sort(first) - ln_median) / dispersion) - empirical)
    names, component = np.unique([m.state.component for m in members], return_inverse=True)
    leading = component[np.argmin(failures[:, 0], axis=0)[first <= ln_median]]
    weakest = names[np.argmax(np.bincount(leading, minlength=len(names)))]
    independent = _failures(*of_all_runs, np.eye(size)[None], _POINTS)
    is_valid = np.all(np.isfinite(ln_theta) & np.isfinite(beta), axis=1)
    values = ln_theta[is_valid], beta[is_valid], correlation[is_valid]
    repeated = _failures(*values, _POINTS_OF_REPLICATES)
    if systems.hazard is not None:
        distributions = [
            _by_models(sample, members, np.flatnonzero(chosen), systems.hazard)
            for sample, chosen in ((failures, np.arange(is_valid.size) == 0), (repeated, is_valid))
        ]
        rated = _rated(distributions[0][0], distributions[1], is_valid, systems.hazard, covered)
        row |= rated | {"rate": rated["rate"]._replace(priors=priors)}
    logs, (medians, dispersions) = np.full((is_valid.size, 2), nan), _quantiles(repeated)
    logs[is_valid] = np.column_stack([medians, np.log(dispersions)])
    fewer_points = Jackknifed.of_replicates(logs, priors)
    ends = fewer_points.interval(settings.confidence)[1] - fewer_points.estimate
    of_theta, of_beta = map(exp_end, ends)
    theta = exp_end(ln_median)
    row |= {"theta": theta, "theta_low": theta / of_theta, "theta_high": theta * of_theta}
    row |= {"beta": dispersion, "beta_low": dispersion / of_beta, "beta_high": dispersion * of_beta}
    row["weakest"] = str(weakest)
    row["theta_correlated"] = exp_end(np.min(ln_theta[0]))
    row["theta_independent"] = exp_end(_quantiles(independent)[0, 0])
    return row | {"status": fits.FITTED, "max_dp": np.max(distance)}


def _by_models(
    failures: Floats, members: Sequence[_Member], rows: Index, hazard: HazardCurve
) -> Floats:
    """Return ln im of the first failure, (R, n), by the demand models of m components.

    ``failures`` (m, R, n) have ln im of each failure by the lognormal curves, which is replaced by
    the intensity of equal probability; ``rows`` (R,) are the numbers of the replicates.
    """
    low, high = np.log(hazard.levels[[0, -1]])
    grid = np.linspace(low - BELOW, high + 0.1, 600)
    first = np.full(failures.shape[1:], np.inf)
    for member, ln_im in zip(members, failures, strict=True):
        curve, ((point, state),) = member.curve, member.curve.points
        z = point.score(state.threshold, state.dispersion, grid[:, None])[:, rows]
        z = np.maximum.accumulate(z, axis=0)
        e = (ln_im - curve.ln_theta[rows, None]) / curve.total[rows, None]
        capacities = [np.interp(scores, z_of, grid) for scores, z_of in zip(e, z.T, strict=True)]
        first = np.minimum(first, capacities)
    return first


def _rated(
    first: Floats,  # ln im of the first failure, shape (n,)
    fewer_points: Floats,  # the same of good estimates with fewer points, (r, n)
    is_valid: Mask,  # estimates that exist: from all runs, then without each motion, (R,)
    hazard: HazardCurve,
    covered: tuple[float, float],
) -> Row:
    rate, changes = hazard.rate_of_failures(first[None]), hazard.rate_of_failures(fewer_points).logs
    logs = np.full(is_valid.size, nan)
    logs[is_valid] = rate.logs[0] + changes - changes[0]
    p_last = float(np.mean(first <= np.log(hazard.levels[-1])))
    shares = hazard.shares(lambda curve: curve.rate_of_failures(first[None]), p_last, *covered)
    return {"rate": rate._replace(logs=logs), "shares": shares}


def _correlation(members: Sequence[_Member], systems: _Systems) -> Floats:
    """Return the correlations of the demands in each replicate, (R, m, m)."""
    # each pair from the runs in which both demands are known; then made positive semi-definite
    size = len(members)
    matrix = np.broadcast_to(np.eye(size), (members[0].curve.beta.size, size, size)).copy()
    for i, j in combinations(range(size), 2):
        rho = systems.models.correlation(members[i].state, members[j].state)
        matrix[:, i, j] = matrix[:, j, i] = rho
    values, vectors = np.linalg.eigh(matrix)
    factor = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    factor /= np.linalg.norm(factor, axis=2, keepdims=True)
    return factor @ np.swapaxes(factor, 1, 2)


def _failures(ln_theta: Floats, beta: Floats, rho: Floats, points: int) -> Floats:
    """Return ln of the intensity at which each component fails, shape (m, R, points)."""
    values, vectors = np.linalg.eigh(rho)
    # symmetric root: unlike other roots it does not depend on the arbitrary signs of eigenvectors
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :] @ np.swapaxes(vectors, 1, 2)
    root *= beta[:, :, None]
    normals = _normals(ln_theta.shape[1], points).T
    return ln_theta.T[:, :, None] + np.swapaxes(root, 0, 1) @ normals


def _quantiles(failures: Floats) -> Floats:
    """Return ln median and dispersion of the first failure, (2, R), from (m, R, points)."""
    levels = special.ndtr(np.array([-1.0, 0.0, 1.0]))
    low, ln_median, high = np.quantile(np.min(failures, axis=0), levels, axis=-1)
    return np.array([ln_median, 0.5 * (high - low)])


@lru_cache(maxsize=32)
def _normals(size: int, points: int) -> Floats:
    """Return quasi-random standard normal vectors, shape (points, size)."""
    from scipy.stats import qmc  # imported only when needed: it is slow to load

    uniform = qmc.Sobol(size, rng=np.random.default_rng(_SEED)).random(points)
    return np.asarray(special.ndtri(np.clip(uniform, 1e-12, 1.0 - 1e-12)))

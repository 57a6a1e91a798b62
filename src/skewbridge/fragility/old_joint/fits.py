"""The two fits of a limit state over the axes: from continuous demands, from exceeded or not.

A demand is censored where a run collapsed, failed or went beyond the model: it is known to exceed
its last value, or the threshold where the limit state counts as exceeded.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.old_joint.by_motion import MotionSums
from skewbridge.fragility.old_joint.mixed import MixedData, fit_mixed
from skewbridge.fragility.old_joint.probit import ProbitFit, fit_probit, refitted_without_motions
from skewbridge.fragility.old_joint.runs import JointRuns
from skewbridge.fragility.old_joint.selection import Cells, Products, best_terms
from skewbridge.fragility.old_joint.surface import Surface
from skewbridge.fragility.old_joint.terms import further_terms, independent, split_terms
from skewbridge.fragility.old_likelihood.existence import (
    ALL_EXCEED,
    NO_EXCEEDANCE,
    NON_INCREASING,
    NON_POSITIVE,
    NOT_APPLICABLE,
)
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.links import FloatArray

MIN_MOTIONS = 5
TOO_FEW_MOTIONS = "too_few_motions"
NO_AXIS = "no_axis_varies"


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFit:
    """A model over the axes: of a demand, or of the outcomes of a limit state.

    Attributes:
        status: ``ok``, or why there is no estimate.
        surface: Its terms.
        sums: Estimate and the shares of the motions.
        without: Parameters without each variant, shape (V, p).
        criterion: Akaike's criterion; of the demand up to a constant.
        press: Root mean square error of a left-out run, of ln demand.
        level_error: Mean error of ln demand by left-out variant, shape (V,).
        path: The nested models that were compared.
        tau: Scatter between motions.
        sigma: Scatter within motions.
        censored: Number of censored runs.
    """

    status: str
    surface: Surface | None = None
    sums: MotionSums | None = None
    without: FloatArray | None = None
    criterion: float = np.nan
    press: float = np.nan
    level_error: FloatArray | None = None
    path: tuple[tuple[str, ...], ...] = ()
    tau: float = np.nan
    sigma: float = np.nan
    censored: int = 0


def main_surface(runs: JointRuns) -> Surface:
    """Return the surface of the main effects that the variants can tell apart."""
    start = Surface(variants=runs.variants, box=runs.box, terms=())
    return replace(start, terms=independent(tuple(runs.box.limits), start.variables))


def fit_demand(
    runs: JointRuns, lower: FloatArray, seen: NDArray[np.bool_], used: NDArray[np.bool_]
) -> JointFit:
    """Fit ln demand over intensity and axes with the motion as random effect.

    Args:
        runs: The runs.
        lower: Demand of each run, or the value that it exceeds.
        seen: Whether the demand is known.
        used: Runs that say anything.
    """
    if not np.any(used & seen):
        return JointFit(status=NOT_APPLICABLE)
    if np.any(used & (lower <= 0.0)):
        return JointFit(status=NON_POSITIVE)
    ln_im, y = runs.ln_im[used], np.log(lower[used])
    variant, known = runs.variant[used], seen[used]
    motion = np.unique(runs.motion[used], return_inverse=True)[1]
    if int(np.max(motion)) + 1 < MIN_MOTIONS:
        return JointFit(status=TOO_FEW_MOTIONS)

    def fit(surface: Surface) -> tuple[Cells, MotionSums]:
        design = surface.design(ln_im, variant)
        found = fit_mixed(MixedData(design=design, lower=y, seen=known, motion=motion))
        cells = Cells(
            y=found.expected,
            ln_im=ln_im,
            motion=motion,
            variant=variant,
            tau=found.tau,
            sigma=found.sigma,
        )
        return cells, found.sums

    start = main_surface(runs)
    design = start.design(ln_im, variant)
    if np.linalg.matrix_rank(design) < design.shape[1]:
        return JointFit(status=NOT_APPLICABLE)
    # ASSUME the expectations of censored demands, which all runs make, stay when a variant is left
    # out
    surface, path = best_terms(fit(start)[0], start)
    cells, sums = fit(surface)
    products = Products(cells, surface)
    press, level_error = products.prediction_errors(surface.terms)
    return JointFit(
        status=FITTED,
        surface=surface,
        sums=sums,
        without=products.without_each(surface.terms),
        criterion=products.criterion(surface.terms),
        press=press,
        level_error=level_error,
        path=tuple(path),
        tau=cells.tau,
        sigma=cells.sigma,
        censored=int(np.sum(~known)),
    )


def fit_outcomes(
    runs: JointRuns,
    exceed: NDArray[np.bool_],
    known: NDArray[np.bool_],
    like: JointFit,
) -> JointFit:
    """Fit exceeded or not over intensity and axes, without slopes that differ.

    The models on the path of the demand (``like``), or from main effects to all products where it
    has none, are compared by the log-likelihood of left-out variants.
    """
    hit = exceed[known].astype(np.float64)
    if hit.size == 0 or not np.any(hit) or np.all(hit):
        empty = hit.size == 0
        return JointFit(
            status=NOT_APPLICABLE if empty else ALL_EXCEED if np.any(hit) else NO_EXCEEDANCE
        )
    motion = np.unique(runs.motion[known], return_inverse=True)[1]
    if int(np.max(motion)) + 1 < MIN_MOTIONS:
        return JointFit(status=TOO_FEW_MOTIONS)
    best, best_score = JointFit(status=NOT_APPLICABLE), -np.inf
    chosen: tuple[ProbitFit, FloatArray] | None = None
    for surface in _surfaces(runs, like):
        design = surface.design(runs.ln_im[known], runs.variant[known])
        if np.linalg.matrix_rank(design) < design.shape[1]:
            break
        fit = fit_probit(design, hit, motion)
        if fit.status != FITTED:
            best = best if best.surface else JointFit(status=fit.status)
            break
        if fit.sums.params[1] <= 0.0:
            best = best if best.surface else JointFit(status=NON_INCREASING)
            break
        without = _without_each(fit, design, runs.variant[known], len(runs.variants))
        score = _left_out_score(without, design, runs.variant[known], hit)
        if best.surface is None or score > best_score:
            best_score, chosen = score, (fit, design)
            best = JointFit(
                status=FITTED,
                surface=surface,
                without=without,
                criterion=2.0 * (design.shape[1] - fit.loglik),
            )
    if chosen is None:
        return best
    return replace(best, sums=refitted_without_motions(*chosen, hit, motion))


def _surfaces(runs: JointRuns, like: JointFit) -> list[Surface]:
    main = main_surface(runs)
    if like.surface is not None:
        box, terms = like.surface.box, [split_terms(each)[0] for each in like.path]
    else:
        box = runs.box.scales[-1]
        level = split_terms(further_terms(replace(main, box=box).variables))[0]
        terms = [list(main.terms), independent((*main.terms, *level), main.variables)]
    nested = list(dict.fromkeys(tuple(each) for each in terms))
    return [Surface(variants=runs.variants, box=box, terms=each) for each in nested]


def _without_each(
    fit: ProbitFit, design: FloatArray, variant: NDArray[np.intp], variants: int
) -> FloatArray:
    """Return the parameters without each variant by one Newton step, shape (V, p)."""
    size = design.shape[1]
    order = np.argsort(variant, kind="stable")
    ends = np.cumsum(np.bincount(variant, minlength=variants))[:-1]
    weighted = design * np.sqrt(np.maximum(fit.curve, 0.0))[:, None]
    own = np.stack([part.T @ part for part in np.split(weighted[order], ends)])
    score = np.stack([np.sum(part, axis=0) for part in np.split(fit.score[order], ends)])
    rest = np.sum(own, axis=0) - own
    out = np.full((variants, size), np.nan)
    sure = np.linalg.matrix_rank(rest, hermitian=True) == size
    step = np.linalg.solve(rest[sure], score[sure][:, :, None])[:, :, 0]
    out[sure] = fit.sums.params - step
    return out


def _left_out_score(
    without: FloatArray, design: FloatArray, variant: NDArray[np.intp], hit: FloatArray
) -> float:
    eta = np.sum(design * without[variant], axis=1)
    score = special.log_ndtr(np.where(hit > 0.0, eta, -eta))
    return float(np.sum(score)) if np.all(np.isfinite(eta)) else -np.inf

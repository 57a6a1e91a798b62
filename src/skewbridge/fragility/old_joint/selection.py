"""Which terms a model over the axes needs: a path by information criterion, then by prediction.

The path adds, one by one, the term that lowers Akaike's criterion of the demands within motions the
most; of the models on it the one that predicts left-out variants best is taken. All fits are read
off from sums of products, which are made once.

References:
    Akaike (1974), IEEE Trans. Autom. Control 19(6):716-723; Allen (1974), Technometrics
    16(1):125-127, for the sum of squares of left-out predictions.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.old_joint.surface import Surface
from skewbridge.fragility.old_joint.terms import further_terms, independent, split_terms
from skewbridge.fragility.old_likelihood.links import FloatArray

_SMALLEST_SQUARE = 1e-300
_THINNEST = 1e-10
_CLEARLY_BETTER = 1e-6  # of one scale of the gap over another


@dataclass(frozen=True, slots=True, kw_only=True)
class Cells:
    """Runs of a demand model, arrays of shape (n,): y and who ran.

    Attributes:
        y: ln demand, in place of a censored value its expectation.
        ln_im: ln intensity.
        motion: Number of the motion, 0 .. G - 1.
        variant: Number of the variant, 0 .. V - 1.
        tau: Scatter between motions.
        sigma: Scatter within motions.
    """

    y: FloatArray
    ln_im: FloatArray
    motion: NDArray[np.intp]
    variant: NDArray[np.intp]
    tau: float
    sigma: float


class Products:
    """Sums of products of the columns of a surface and of y, whole and without each variant."""

    def __init__(self, cells: Cells, surface: Surface) -> None:
        self.terms = surface.terms
        design = surface.design(cells.ln_im, cells.variant)
        values = np.column_stack([design, cells.y])
        self._cells, self._design = cells, design
        variants, motions = len(surface.variants), int(np.max(cells.motion)) + 1
        place = cells.variant * motions + cells.motion
        cell = np.stack(
            [np.bincount(place, column, minlength=variants * motions) for column in values.T],
            axis=1,
        ).reshape(variants, motions, -1)
        count = np.bincount(place, minlength=variants * motions).reshape(variants, motions)
        whole, number = np.sum(cell, axis=0), np.sum(count, axis=0).astype(np.float64)
        total = values.T @ values
        # within motions: the criterion
        self._within = total - (whole / number[:, None]).T @ whole
        self._freedom = cells.y.size - motions
        # without each variant: the prediction, by generalised least squares
        self._others, self._left = whole - cell, number - count
        ratio = cells.tau**2 / (cells.sigma**2 + self._left * cells.tau**2)
        order = np.argsort(cells.variant, kind="stable")
        parts = np.split(
            values[order], np.cumsum(np.bincount(cells.variant, minlength=variants))[:-1]
        )
        own = np.stack([part.T @ part for part in parts])
        shrunk = self._others * np.sqrt(ratio)[:, :, None]
        self._without = total - own - np.swapaxes(shrunk, 1, 2) @ shrunk

    def columns(self, terms: Sequence[str]) -> list[int]:
        """Return the numbers of the columns of a model with some of the terms, in its order."""
        level, slope = split_terms(self.terms)
        place = {term: 2 + number for number, term in enumerate(level)}
        steep = {term: 2 + len(level) + number for number, term in enumerate(slope)}
        own_level, own_slope = split_terms(terms)
        return [0, 1, *(place[name] for name in own_level), *(steep[name] for name in own_slope)]

    def criterion(self, terms: Sequence[str]) -> float:
        """Return Akaike's criterion of a model, up to a constant of the data."""
        used = self.columns(terms)[1:]
        matrix, right = self._within[np.ix_(used, used)], self._within[used, -1]
        explained = float(right @ np.linalg.pinv(matrix, hermitian=True) @ right)
        left = max(float(self._within[-1, -1]) - explained, _SMALLEST_SQUARE)
        return self._freedom * float(np.log(left / self._freedom)) + 2.0 * len(terms)

    def without_each(self, terms: Sequence[str]) -> FloatArray:
        """Return the parameters without each variant, shape (V, p); NaN where it is needed."""
        used = self.columns(terms)
        matrix = self._without[:, used][:, :, used]
        scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), _SMALLEST_SQUARE))
        matrix = matrix / scale[:, :, None] / scale[:, None, :]
        sure = np.linalg.eigvalsh(matrix)[:, 0] > _THINNEST
        out = np.full(scale.shape, np.nan)
        right = (self._without[:, used, -1] / scale)[sure]
        out[sure] = np.linalg.solve(matrix[sure], right[:, :, None])[:, :, 0] / scale[sure]
        return out

    def prediction_errors(self, terms: Sequence[str]) -> tuple[float, FloatArray]:
        """Return how well the others predict each variant.

        Returns:
            Root mean square of the error of ln demand of a run, relative to the other variants
            under its motion (infinite where a variant cannot be left out), and mean error by
            variant, shape (V,).
        """
        used = self.columns(terms)
        params = self.without_each(terms)
        variant, motion = self._cells.variant, self._cells.motion
        with np.errstate(invalid="ignore", divide="ignore"):
            level = self._others[:, :, -1] - np.einsum(
                "vgp,vp->vg", self._others[:, :, used], params
            )
            level = np.where(self._left > 0.0, level / self._left, np.nan)
        own = self._cells.y - np.sum(self._design[:, used] * params[variant], axis=1)
        error = own - level[variant, motion]
        known = np.isfinite(error)
        if not np.any(known):
            return np.inf, np.full(params.shape[0], np.nan)
        count = np.bincount(variant[known], minlength=params.shape[0])
        total = np.bincount(variant[known], error[known], minlength=params.shape[0])
        mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        missing = float(np.mean(~np.isfinite(params[:, 0])))
        return float(np.sqrt(np.mean(error[known] ** 2))) if missing == 0.0 else np.inf, mean


def best_terms(cells: Cells, start: Surface) -> tuple[Surface, list[tuple[str, ...]]]:
    """Return the surface that predicts left-out variants best, and the path it was found on.

    The main effects of ``start`` always take part; both scales of the gap are tried.
    """
    found: list[tuple[float, Surface, list[tuple[str, ...]]]] = []
    for box in start.box.scales:
        main = Surface(variants=start.variants, box=box, terms=start.terms)
        further = further_terms(main.variables)
        level, slope = split_terms(further)
        able = independent((*main.terms, *level), main.variables)[len(main.terms) :]
        tails = [f"{term}:ln_im" for term in slope if term in (*main.terms, *able)]
        every = Surface(variants=start.variants, box=box, terms=(*main.terms, *able, *tails))
        products = Products(cells, every)
        path = _path(products, main.terms, (*able, *tails))
        errors = [products.prediction_errors(terms)[0] for terms in path]
        first = int(np.argmin(errors))
        chosen = Surface(variants=start.variants, box=box, terms=path[first])
        found.append((errors[first], chosen, path))
    best = found[0]
    for other in found[1:]:  # of equals the gap as it is
        best = other if other[0] < best[0] * (1.0 - _CLEARLY_BETTER) else best
    return best[1], best[2]


def _path(
    products: Products, main: tuple[str, ...], further: Sequence[str]
) -> list[tuple[str, ...]]:
    path, left = [main], list(further)
    lowest = products.criterion(main)
    while left:
        trials = {term: products.criterion((*path[-1], term)) for term in left}
        term = min(trials, key=lambda name: trials[name])
        if trials[term] >= lowest:
            break
        lowest = trials[term]
        left.remove(term)
        path.append((*path[-1], term))
    return path

"""Terms over the variants of a study, and how coefficients become medians and a dispersion."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.fragility.old_joint.terms import AxisBox, independent, split_terms, term_matrix
from skewbridge.fragility.old_likelihood.links import FloatArray

_FLATTEST_SLOPE = 1e-3


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A linear predictor over intensity and axes: level + slope ln x, both linear in terms.

    Attributes:
        variants: One row per variant, with its axes.
        box: The axes that differ, and their scales.
        terms: Terms of the level, and those with ``ln_im`` of the slope.
    """

    variants: pd.DataFrame
    box: AxisBox
    terms: tuple[str, ...]

    @cached_property
    def variables(self) -> dict[str, FloatArray]:
        """Variables of the model by axis, shape (V,) each."""
        axes = {name: self.variants[name].to_numpy(dtype=np.float64) for name in self.box.limits}
        return self.box.variables(axes)

    @cached_property
    def _parts(self) -> tuple[FloatArray, FloatArray]:
        """Matrices of level and slope, shapes (V, 1 + level terms), (V, 1 + slope terms)."""
        level, slope = split_terms(self.terms)
        return term_matrix(level, self.variables), term_matrix(slope, self.variables)

    @cached_property
    def median_terms(self) -> tuple[str, ...]:
        """Terms of ln theta: those of the level, and of the slope where the level lacks them."""
        level, slope = split_terms(self.terms)
        return independent(tuple(dict.fromkeys([*level, *slope])), self.variables)

    @cached_property
    def median_matrix(self) -> FloatArray:
        """Matrix of the terms of ln theta, shape (V, 1 + q)."""
        return term_matrix(self.median_terms, self.variables)

    def design(self, ln_im: FloatArray, variant: NDArray[np.intp]) -> FloatArray:
        """Return the columns of runs: 1, ln x, level terms, slope terms times ln x."""
        level, slope = (part[variant] for part in self._parts)
        return np.column_stack([level[:, 0], ln_im, level[:, 1:], slope[:, 1:] * ln_im[:, None]])

    def medians(self, params: FloatArray, ln_capacity: float) -> tuple[FloatArray, FloatArray]:
        """Return ln theta and slope of every variant, shapes (K, V), for parameters (K, p).

        ln theta is NaN where the slope is not positive.
        """
        level_part, slope_part = self._parts
        size = level_part.shape[1]
        level = params[:, :1] + params[:, 2 : size + 1] @ level_part[:, 1:].T
        slope = params[:, 1:2] + params[:, size + 1 :] @ slope_part[:, 1:].T
        rising = slope > _FLATTEST_SLOPE
        return np.where(rising, (ln_capacity - level) / np.where(rising, slope, 1.0), np.nan), slope

    def curves(
        self, params: FloatArray, variance: FloatArray, ln_capacity: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return coefficients of ln theta (K, 1 + q) and ln of the common beta (K,).

        The medians of the variants are carried over to the terms by least squares: exact where
        the slope is common.
        """
        # ASSUME one dispersion for all variants: scatter over the mean slope
        ln_theta, slope = self.medians(params, ln_capacity)
        mean = np.mean(slope, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            ln_beta = 0.5 * np.log(variance) - np.log(np.where(mean > 0.0, mean, np.nan))
        return ln_theta @ np.linalg.pinv(self.median_matrix).T, ln_beta

    def left_out_medians(self, params: FloatArray, ln_capacity: float) -> FloatArray:
        """Return ln theta of every variant as the others predict it, shape (V,).

        ``params`` are those without each variant, shape (V, p).
        """
        ln_theta = self.medians(params, ln_capacity)[0]
        basis = self.median_matrix
        count, size = basis.shape
        out = np.full(count, np.nan)
        if count <= size:
            return out
        total = basis.T @ basis
        rest = total - basis[:, :, None] * basis[:, None, :]
        own = np.diagonal(ln_theta)
        right = ln_theta @ basis - own[:, None] * basis
        sure = np.linalg.matrix_rank(rest, hermitian=True) == size
        coefficients = np.linalg.solve(rest[sure], right[sure][:, :, None])[:, :, 0]
        out[sure] = np.sum(coefficients * basis[sure], axis=1)
        return out

"""A joint model as it is stored: medians, dispersion and their interval anywhere in the box."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
from scipy import special, stats

from skewbridge.fragility.old_joint.terms import AxisBox, term_matrix
from skewbridge.fragility.old_likelihood.links import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class JointModel:
    """ln theta linear in terms of the axes, with a common beta.

    Attributes:
        box: Axes, their limits and scales.
        terms: Terms after the constant.
        coefficients: Of ln theta, shape (1 + q,).
        ln_beta: ln of the dispersion from record to record.
        covariance: Of coefficients and ln beta, robust to motions, shape (2 + q, 2 + q).
        freedom: Degrees of freedom of the intervals.
        level: Their confidence level.
        slope: Mean slope of ln demand on ln intensity; NaN where there is none.
        dispersion: Of the capacity.
    """

    box: AxisBox
    terms: tuple[str, ...]
    coefficients: FloatArray
    ln_beta: float
    covariance: FloatArray
    freedom: int
    level: float
    slope: float
    dispersion: float

    @classmethod
    def of_row(cls, row: Mapping[str, Any]) -> "JointModel":
        """Return the model of a row of results/fragility/joint.parquet."""
        coefficients = np.asarray(row["coefficients"], dtype=np.float64)
        size = coefficients.size + 1
        ends = {
            name: (float(low), float(high)) for name, (low, high) in json.loads(row["box"]).items()
        }
        box = AxisBox(
            limits={name: (low, high) for name, (low, high) in ends.items() if low < high},
            fixed={name: (low, high) for name, (low, high) in ends.items() if low == high},
            signed_skew=bool(row["signed_skew"]),
            log_gap=bool(row["log_gap"]),
        )
        return cls(
            box=box,
            terms=tuple(filter(None, str(row["terms"]).split(";"))),
            coefficients=coefficients,
            ln_beta=float(np.log(row["beta"])),
            covariance=np.asarray(row["covariance"], dtype=np.float64).reshape(size, size),
            freedom=int(row["n_motions"]) - 2,
            level=float(row["level"]),
            slope=float(row["slope"]),
            dispersion=float(row["capacity_dispersion"]),
        )

    @property
    def beta(self) -> float:
        """Dispersion from record to record."""
        return float(np.exp(self.ln_beta))

    @property
    def beta_total(self) -> float:
        """Dispersion with that of the capacity; NaN where its share in intensity is not known."""
        if self.dispersion == 0.0:
            return self.beta
        return float(np.hypot(self.beta, self.dispersion / self.slope))

    @property
    def ci_beta(self) -> tuple[float, float]:
        """Interval of the dispersion."""
        half = self._quantile(self.level) * float(np.sqrt(self.covariance[-1, -1]))
        return self.beta * float(np.exp(-half)), self.beta * float(np.exp(half))

    def _quantile(self, level: float) -> float:
        return float(stats.t.ppf(0.5 + 0.5 * level, self.freedom))

    def vector(self, values: Mapping[str, float]) -> FloatArray:
        """Return the terms at values of the axes, shape (1 + q,)."""
        axes = {name: np.array([float(values[name])]) for name in self.box.limits}
        return term_matrix(self.terms, self.box.variables(axes))[0]

    def median(self, values: Mapping[str, float]) -> tuple[float, float, float]:
        """Return theta and the ends of its interval at values of the axes."""
        return self._exponential(self.vector(values), self.level)

    def ratio(
        self, below: Mapping[str, float], above: Mapping[str, float], level: float
    ) -> tuple[float, float, float]:
        """Return the ratio of the medians at two places, above over below, and its interval."""
        return self._exponential(self.vector(above) - self.vector(below), level)

    def _exponential(self, vector: FloatArray, level: float) -> tuple[float, float, float]:
        estimate = float(vector @ self.coefficients)
        variance = float(vector @ self.covariance[:-1, :-1] @ vector)
        half = self._quantile(level) * float(np.sqrt(variance)) if variance >= 0.0 else nan
        low, middle, high = (float(np.exp(estimate + shift)) for shift in (-half, 0.0, half))
        return middle, low, high


def exceedance(at: float, theta: float, beta: float) -> float:
    """Return the probability of exceedance at an intensity."""
    return float(special.ndtr(np.log(at / theta) / beta))

"""What the axes of a study become in the joint model: variables, terms and the box of the study.

The skew enters as skew/60 degrees (its size, unless both signs are in the study), the joint gap as
gap/50.8 mm or its logarithm, friction as it is, every other axis as the share of its largest value.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.tables.key_columns import axis_names
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import AXES, axis

SKEW: Final = "skew_deg"
GAP: Final = "gap_mm"
LN_IM: Final = "ln_im"
REFERENCE_GAP_MM: Final = 50.8  # 2 in
_LEVELS_OF_A_SQUARE: Final = 3
_SLACK: Final = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisBox:
    """The axes of the variants of one bridge and abutment model.

    Attributes:
        limits: Smallest and largest value in the study by axis that differs; of the skew's size
            where it is meant.
        fixed: The same of the axes that do not differ.
        signed_skew: Whether skews of both signs are in the study, so that its sign counts.
        log_gap: Whether the gap enters by its logarithm.
    """

    limits: Mapping[str, tuple[float, float]]
    fixed: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    signed_skew: bool = False
    log_gap: bool = False

    @property
    def scales(self) -> "tuple[AxisBox, ...]":
        """The box with every scale of the gap that its values allow."""
        low = self.limits.get(GAP, (0.0, 0.0))[0]
        return (self, replace(self, log_gap=True)) if low > 0.0 else (self,)

    def measured(self, name: str, value: FloatArray) -> FloatArray:
        """Return an axis as the box counts it: of a skew its size, unless the sign counts."""
        return np.abs(value) if name == SKEW and not self.signed_skew else value

    def variables(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return the variables of the model at values of the axes, by axis."""
        return {name: self._variable(name, np.asarray(values[name])) for name in self.limits}

    def _variable(self, name: str, value: FloatArray) -> FloatArray:
        value = self.measured(name, value)
        if name == GAP:
            return np.log(value / REFERENCE_GAP_MM) if self.log_gap else value / REFERENCE_GAP_MM
        told = axis(name)
        if told.unit == "-" or not 0.0 < told.high < np.inf:
            return value
        return value / told.high

    def check(self, values: Mapping[str, float]) -> None:
        """Check that a point lies inside the box; axes that the model lacks do not count.

        Raises:
            InputError: A value is missing or outside, or of an axis that the study does not know;
                names the axis and its limits.
        """
        known = {**self.fixed, **self.limits}
        lacking = {each.name for each in AXES}
        for name in values:
            if name not in known and name not in lacking:
                raise InputError(f"{name} is no axis of the study", column=name)
        for name, (low, high) in known.items():
            if name not in values:
                if name in self.fixed:
                    continue
                raise InputError(
                    f"{name} is missing: the study varies it within {low:g}..{high:g}", column=name
                )
            value = float(self.measured(name, np.array(values[name], dtype=np.float64)))
            if not low - _SLACK <= value <= high + _SLACK:
                raise InputError(
                    f"{name} must be within {low:g}..{high:g}, the box of the study, got "
                    f"{values[name]:g}",
                    column=name,
                )


def axes_of_model(table: pd.DataFrame, abutment: str) -> list[str]:
    """Return the axis columns that an abutment model has; all of them for a foreign model."""
    names = axis_names(table)
    if abutment not in ABUTMENTS:
        return names
    lacking = {each.name for each in AXES} - {SKEW} - ABUTMENTS[abutment].axes
    return [name for name in names if name not in lacking]


def box_of(variants: pd.DataFrame, names: Iterable[str]) -> AxisBox:
    """Return the box of some axes over variants, one row each."""
    signed = False
    limits: dict[str, tuple[float, float]] = {}
    for name in names:
        value = variants[name].to_numpy(dtype=np.float64)
        if name == SKEW:
            signed = bool(np.any(value > 0.0) and np.any(value < 0.0))
            value = value if signed else np.abs(value)
        if np.all(np.isfinite(value)):
            limits[name] = (float(np.min(value)), float(np.max(value)))
    differ = {name: ends for name, ends in limits.items() if ends[0] < ends[1]}
    fixed = {name: ends for name, ends in limits.items() if name not in differ}
    return AxisBox(limits=differ, fixed=fixed, signed_skew=signed)


def further_terms(variables: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Return what may join the main effects: the skew's square, products of two axes, and slopes.

    A slope is a term times ``ln_im``: where the demand of a variant grows faster with the
    intensity.
    """
    terms: list[str] = []
    if SKEW in variables and np.unique(variables[SKEW]).size >= _LEVELS_OF_A_SQUARE:
        terms.append(f"{SKEW}:{SKEW}")
    terms += [f"{a}:{b}" for a, b in combinations(variables, 2)]
    slopes = [*variables, *terms[: int(f"{SKEW}:{SKEW}" in terms)]]
    return (*terms, *(f"{name}:{LN_IM}" for name in slopes))


def split_terms(terms: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the terms of the level, and those of the slope without their ``ln_im``."""
    tail = f":{LN_IM}"
    level = [term for term in terms if not term.endswith(tail)]
    return level, [term.removesuffix(tail) for term in terms if term.endswith(tail)]


def term_matrix(terms: Sequence[str], variables: Mapping[str, FloatArray]) -> FloatArray:
    """Return a column of ones and one column per term (names joined by colons), shape (V, 1+q)."""
    size = next((value.size for value in variables.values()), 1)
    products = [np.prod([variables[name] for name in term.split(":")], axis=0) for term in terms]
    return np.column_stack([np.ones(size), *products])


def independent(terms: Sequence[str], variables: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Return the terms that the variants can tell from those before them; one variant is spare."""
    kept: tuple[str, ...] = ()
    for term in terms:
        matrix = term_matrix((*kept, term), variables)
        if matrix.shape[1] < matrix.shape[0] or len(kept) < len(variables):
            kept = (*kept, term) if np.linalg.matrix_rank(matrix) == matrix.shape[1] else kept
    return kept

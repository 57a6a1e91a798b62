"""Limit states as data: read, checked, converted to the unit of their demand column."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.units import FOOT, INCH, KIP, KJ, KN, MM

COLLAPSE_EXCEEDS: Final = "exceeds"
COLLAPSE_BY_PEAK: Final = "peak"
MAX_DISPERSION: Final = 2.0
# Below this a dispersion is more likely a slip of units (0.25 written in thousandths).
SMALL_DISPERSION: Final = 0.05
_PERCENT: Final = 0.01

# dimension and factor to the SI unit
_UNITS: Final[dict[str, tuple[str, float]]] = {
    "m": ("length", 1.0),
    "mm": ("length", MM),
    "in": ("length", INCH),
    "ft": ("length", FOOT),
    "kn": ("force", KN),
    "kip": ("force", KIP),
    "kj": ("energy", KJ),
    "rad": ("angle", 1.0),
    "mps": ("velocity", 1.0),
    "mps2": ("acceleration", 1.0),
    "g": ("gravity units", 1.0),
    "s": ("time", 1.0),
    "ratio": ("ratio", 1.0),
    "percent": ("ratio", _PERCENT),
}
# Last words of column names that are ratios without saying so.
_RATIO_WORDS: Final = ("dcr", "ductility", "friction", "closures")
_KEYS: Final = {"component", "demand", "unit", "dispersion", "collapse", "citation", "states"}


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitState:
    """Capacity of one demand at one degree of damage.

    Attributes:
        component: What is damaged, for example ``column_drift``.
        name: Degree of damage, for example ``moderate``.
        demand: Column of the demands table.
        threshold: Median capacity in the unit of that column.
        dispersion: Standard deviation of the logarithm of the capacity; 0 is a plain threshold.
        unit: Unit of the demand column.
        collapse: ``exceeds`` or ``peak``: whether a collapsed run exceeds by definition.
        citation: Where the numbers come from.
    """

    component: str
    name: str
    demand: str
    threshold: float
    dispersion: float
    unit: str
    collapse: str
    citation: str

    @property
    def warnings(self) -> tuple[str, ...]:
        """``small_capacity_dispersion`` where a slip of units is likely."""
        return ("small_capacity_dispersion",) if 0.0 < self.dispersion < SMALL_DISPERSION else ()


def load_limit_states(path: Path) -> list[LimitState]:
    """Read limit states from a YAML file; see config/limit_states.yaml for the keys.

    Raises:
        InputError: The file is missing, or an entry is wrong; names the entry and the key.
    """
    try:
        with path.open(encoding="utf-8") as file:
            data = yaml.safe_load(file)
    except (OSError, yaml.YAMLError) as error:
        raise InputError(f"cannot read limit states from {path}: {error}") from error
    return limit_states_of(data)


def limit_states_of(data: object) -> list[LimitState]:
    """Return the limit states of parsed configuration data, sorted as written.

    Raises:
        InputError: An entry is wrong; names the entry (by number, from 0) and the key.
    """
    if not isinstance(data, list) or not data:
        raise InputError("limit states must be a list with at least one entry")
    out: list[LimitState] = []
    for row, entry in enumerate(data):
        out += _entry_states(row, entry)
    seen: set[tuple[str, str]] = set()
    for state in out:
        key = (state.component, state.name)
        if key in seen:
            raise InputError(f"limit state {state.component}/{state.name} is defined twice")
        seen.add(key)
    return out


def demand_unit(column: str) -> str:
    """Return the unit that the name of a demand column carries, for example ``m``.

    Raises:
        InputError: The name carries no unit.
    """
    last = column.rsplit("_", 1)[-1]
    if last in _UNITS:
        return last
    if last in _RATIO_WORDS:
        return "ratio"
    raise InputError(f"demand column {column!r} carries no unit in its name", column=column)


def exceedance_probability(
    ln_demand: FloatArray, ln_capacity: float, dispersion: float
) -> FloatArray:
    """Return P(C < D) of a lognormal capacity, Phi[(ln D - ln C)/dispersion]; 0 or 1 without.

    References:
        Cornell et al. (2002): capacity as a lognormal variable independent of demand.
    """
    if dispersion == 0.0:
        return (ln_demand > ln_capacity).astype(np.float64)
    return np.asarray(special.ndtr((ln_demand - ln_capacity) / dispersion))


def convolved_curve(
    im: FloatArray,
    *,
    ln_a: float,
    b: float,
    sigma: float,
    capacity: float,
    capacity_dispersion: float,
    model_dispersion: float = 0.0,
) -> tuple[float, float, FloatArray]:
    """Return theta, beta and P(D > C) of a lognormal demand model against a lognormal capacity.

    P = Phi[(ln a + b ln x - ln C)/sqrt(sigma^2 + beta_c^2 + beta_m^2)]; theta is that of the
    median capacity, beta = sqrt(...)/b.
    """
    spread = float(np.sqrt(sigma**2 + capacity_dispersion**2 + model_dispersion**2))
    eta = (ln_a + b * np.log(im) - np.log(capacity)) / spread
    theta = float(np.exp((np.log(capacity) - ln_a) / b))
    return theta, spread / b, np.asarray(special.ndtr(eta))


def _entry_states(row: int, entry: object) -> list[LimitState]:
    where = f"limit state entry {row}"
    if not isinstance(entry, Mapping):
        raise InputError(f"{where} must be a mapping, got {entry!r}", row=row)
    unknown = set(entry) - _KEYS
    if unknown:
        raise InputError(
            f"{where}: unknown key {sorted(map(str, unknown))[0]!r} (known: {sorted(_KEYS)})",
            row=row,
        )
    for key in ("component", "demand", "unit", "citation"):
        if not isinstance(entry.get(key), str) or not entry[key]:
            raise InputError(
                f"{where}: {key} must be a text, got {entry.get(key)!r}", row=row, column=key
            )
    collapse = entry.get("collapse", COLLAPSE_EXCEEDS)
    if collapse not in (COLLAPSE_EXCEEDS, COLLAPSE_BY_PEAK):
        raise InputError(
            f"{where}: collapse must be exceeds or peak, got {collapse!r}",
            row=row,
            column="collapse",
        )
    states = entry.get("states")
    if not isinstance(states, Mapping) or not states:
        raise InputError(
            f"{where}: states must map names to medians, got {states!r}", row=row, column="states"
        )
    factor = _factor(where, row, entry["unit"], entry["demand"])
    out: list[LimitState] = []
    for name, value in states.items():
        own: Mapping[str, Any] = value if isinstance(value, Mapping) else {"median": value}
        text = f"{where}, state {name!r}"
        median = _number(text, row, "median", own.get("median"))
        if median <= 0.0:
            raise InputError(
                f"{text}: median must be > 0, got {median:g}", row=row, column="median"
            )
        spread = own.get("dispersion", entry.get("dispersion"))
        dispersion = _number(text, row, "dispersion", spread)
        if not 0.0 <= dispersion <= MAX_DISPERSION:
            raise InputError(
                f"{text}: dispersion must be within 0..{MAX_DISPERSION:g}, got {dispersion:g}",
                row=row,
                column="dispersion",
            )
        out.append(
            LimitState(
                component=entry["component"],
                name=str(name),
                demand=entry["demand"],
                threshold=median * factor,
                dispersion=dispersion,
                unit=demand_unit(entry["demand"]),
                collapse=str(collapse),
                citation=entry["citation"],
            )
        )
    return out


def _factor(where: str, row: int, unit: str, demand: str) -> float:
    if unit not in _UNITS:
        raise InputError(
            f"{where}: unit must be one of {', '.join(_UNITS)}, got {unit!r}",
            row=row,
            column="unit",
        )
    dimension, factor = _UNITS[unit]
    target, target_factor = _UNITS[demand_unit(demand)]
    if dimension != target:
        raise InputError(
            f"{where}: unit {unit!r} is a {dimension}, but {demand} is a {target}",
            row=row,
            column="unit",
        )
    return factor / target_factor


def _number(where: str, row: int, key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        hint = " (YAML reads 2e7 as text: write 2.0e+7)" if isinstance(value, str) else ""
        raise InputError(
            f"{where}: {key} must be a number, got {value!r}{hint}", row=row, column=key
        )
    return float(value)

"""Read limit states, check them and convert them to the unit of their demand column."""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import inf, nan
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator

from skewbridge.demands.columns import column_of, joint_columns
from skewbridge.demands.validity import COLUMN_FAILURE_RATIO, FAILURE_DEMANDS
from skewbridge.errors import InputError, raise_all
from skewbridge.files.tables import Floats
from skewbridge.files.text import checked, read_yaml, shortened, shown_path
from skewbridge.units import FOOT, INCH, KIP, KJ, KN, MM

COLLAPSE_EXCEEDS: Final = "exceeds"
COLLAPSE_PEAK: Final = "peak"
MAX_DISPERSION: Final = 2.0
_STRICT: Final = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)

#: Dimension, and factor to the SI unit, of units that are converted to the unit of the demand.
_UNITS: Final[dict[str, tuple[str, float]]] = {
    "m": ("length", 1.0), "mm": ("length", MM), "in": ("length", INCH), "ft": ("length", FOOT),
    "kn": ("force", KN), "kip": ("force", KIP), "kj": ("energy", KJ), "rad": ("angle", 1.0),
    "mps": ("velocity", 1.0), "mps2": ("acceleration", 1.0), "g": ("gravity units", 1.0),
    "s": ("time", 1.0), "ratio": ("ratio", 1.0), "percent": ("ratio", 0.01),
}  # fmt: skip
# ASSUME capacities of drifts and of lengths (m) outside these ranges are in another unit
_USUAL: Final = {"_drift_ratio": (0.001, 0.2), "_m": (0.001, 5.0)}


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitState:
    """Capacity of a component for one demand and one degree of damage (see `LimitStateEntry`)."""

    component: str
    name: str  # degree of damage, for example ``moderate``
    demand: str
    threshold: float  # median capacity in the unit of the demand column
    dispersion: float  # standard deviation of ln capacity; 0: plain threshold; NaN: see `modes`
    unit: str = ""  # unit of the demand column
    collapse: str = COLLAPSE_EXCEEDS
    citation: str = ""
    #: Degree of damage of the bridge in system curves; None: equal to `name`; empty: not used.
    degree: str | None = None
    #: States of the failure modes of which this state is the union; empty for other states.
    modes: "tuple[LimitState, ...]" = ()

    @property
    def system_degree(self) -> str:
        """Degree of damage of the bridge in system curves; empty if the state is not used there."""
        return self.name if self.degree is None else self.degree

    @property
    def columns(self) -> dict[str, Any]:
        """Columns that describe the state in tables of results."""
        state = {"component": self.component, "limit_state": self.name, "demand": self.demand}
        return state | {"threshold": self.threshold, "capacity_dispersion": self.dispersion}

    @property
    def warnings(self) -> tuple[str, ...]:
        """``small_capacity_dispersion`` if the dispersion is below 0.05, probably a wrong unit."""
        return ("small_capacity_dispersion",) if 0.0 < self.dispersion < 0.05 else ()

    @property
    def doubt(self) -> str:
        """Sentence if the capacity looks like a number in another unit, or an empty text."""
        ends = (end for end in _USUAL if self.demand.endswith(end))
        low, high = _USUAL[end] if (end := next(ends, None)) else (0.0, inf)
        if low <= self.threshold <= high:
            return ""
        text = f"{self.demand} of {self.threshold:g} is outside the usual {low:g} to {high:g}"
        return f"limit state {self.key}: {text}: check its unit"

    @property
    def key(self) -> str:
        """Name of the state in tables of effects, ``component/name``."""
        return f"{self.component}/{self.name}"


type States = Sequence[LimitState]

#: Component name of column failure, which combines the demands of both failure modes.
COLUMN_FAILURE: Final = "column_failure"
#: States whose pooled effects on medians are the headline results of a study, most severe first.
HEADLINE_STATES: Final = (
    f"{COLUMN_FAILURE}/any",
    "column_shear/dcr_100",
    "column_curvature/moderate",
    "unseating/slight",
    "bearing/slight",
)


def hazus_factor(skew_deg: ArrayLike) -> Floats:
    """Return the factor by which Hazus multiplies the medians of a bridge with skew.

    source: Hazus 6.1, section 7, FEMA (2022): sqrt(sin(90 deg - skew)); not for slight damage.
    """
    return np.sqrt(np.sin(np.radians(90.0 - np.abs(skew_deg))))


@cache
def _column_failures() -> tuple[LimitState, ...]:
    return tuple(load_limit_states(Path(__file__).with_name("column_failure.yaml")))


def with_column_failure(states: States, columns: Collection[str]) -> list[LimitState]:
    """Return limit states and the states of column failure, unless these are already defined.

    States of inner joints are left out if ``columns`` (of the demands table) lack their demand.
    A column fails in shear if its shear demand/capacity ratio exceeds 1, and in flexure if its
    drift/capacity ratio exceeds 1. The state ``any`` is exceeded if either ratio exceeds 1. A state
    is added only if its demand is one of ``columns``. A state of the larger ratio becomes the union
    of both modes, each with the capacity dispersion of its own state, if there is one.
    """
    has_failures = any(state.component == COLUMN_FAILURE for state in states)
    failures = () if has_failures else _column_failures()
    absent = {column.name for column in joint_columns(s.demand for s in states)}.difference(columns)
    all_states = [state for state in states if state.demand not in absent]
    all_states += [state for state in failures if state.demand in columns]
    return [_with_modes(state, all_states, columns) for state in all_states]


def _with_modes(state: LimitState, states: States, columns: Collection[str]) -> LimitState:
    """Return a state of `COLUMN_FAILURE_RATIO` with its failure modes; others are unchanged."""
    if state.demand != COLUMN_FAILURE_RATIO:
        return state
    key = state.component, state.threshold
    by_demand = {mode.demand: mode for mode in states if (mode.component, mode.threshold) == key}
    names = [name for name in FAILURE_DEMANDS.values() if name in columns]
    modes = tuple(by_demand.get(name, replace(state, demand=name)) for name in names)
    return replace(state, modes=modes, dispersion=nan) if modes else state


# Names of states become parts of file names and identifiers of other tools.
type Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,59}$")]
type Dispersion = Annotated[float, Field(ge=0.0, le=MAX_DISPERSION)]


class StateEntry(BaseModel):
    """Median capacity for one degree of damage, with an optional dispersion."""

    model_config = _STRICT

    median: float = Field(gt=0.0, le=1.0e12, description="median capacity in the unit of the entry")
    dispersion: Dispersion | None = Field(None, description="overrides the entry's dispersion")


def _with_median(value: Any) -> Any:
    return value if isinstance(value, dict | StateEntry) else {"median": value}


class LimitStateEntry(BaseModel):
    """One entry of a file of limit states: the capacities of one component."""

    model_config = _STRICT

    component: Name = Field(description="damaged component")
    demand: str = Field(min_length=1, max_length=100, description="column of the demands table")
    unit: str = Field(
        description=f"unit of the medians: {', '.join(_UNITS)}, or the unit of the demand",
        max_length=20,
        json_schema_extra={"examples": list(_UNITS)},
    )
    dispersion: Dispersion | None = Field(
        None,
        description="standard deviation of the logarithm of the capacity; 0 is a plain threshold",
    )
    collapse: Literal["exceeds", "peak"] = Field(
        COLLAPSE_EXCEEDS,
        description="exceeds: a collapse before a column failure exceeds the state; "
        "peak: only the peak up to the collapse counts",
    )
    citation: str = Field(min_length=1, max_length=1000, description="source of the capacities")
    states: dict[
        Name,
        Annotated[
            StateEntry, BeforeValidator(_with_median, json_schema_input_type=float | StateEntry)
        ],
    ] = Field(min_length=1, description="median capacity for each degree of damage")
    degrees: dict[str, str] | None = Field(
        None,
        description="for system curves: degree of damage of the bridge for each state. A state "
        "that is not listed is left out of system curves. "
        "With null, the name of each state is its degree of damage",
    )

    @field_validator("degrees")
    @classmethod
    def _names_existing_states(
        cls, degrees: dict[str, str] | None, info: ValidationInfo
    ) -> dict[str, str] | None:
        unknown = set(degrees or {}) - set(info.data.get("states", {}))
        if unknown:
            raise ValueError(f"names {', '.join(sorted(unknown))}, but states has no such state")
        return degrees

    @field_validator("unit")
    @classmethod
    def _has_dimension_of_demand(cls, unit: str, info: ValidationInfo) -> str:
        demand, spelled = info.data.get("demand"), _spelled(unit)
        required = spelled if demand is None else demand_unit(demand, spelled)
        if spelled not in _UNITS and spelled != required:
            raise ValueError(f"must be one of {', '.join(dict.fromkeys((*_UNITS, required)))}")
        dimension, target = (_UNITS.get(name, (name,))[0] for name in (spelled, required))
        if dimension != target:
            raise ValueError(f"is a unit of {dimension}, but {demand} has one of {target}")
        return spelled

    def limit_states(self, where: str) -> list[LimitState]:
        """Return the limit states in the unit of their demand column; medians must increase."""
        unit = demand_unit(self.demand, self.unit)
        factor = 1.0 if unit == self.unit else _UNITS[self.unit][1] / _UNITS[unit][1]
        for (mild, milder), (severe, state) in pairwise(self.states.items()):
            if state.median <= milder.median:
                text = f"median {state.median:g} must exceed {milder.median:g} (state {mild})"
                raise InputError(f"{where}: states.{severe}: {text}; list mild states first")
        common = self.model_dump(include={"component", "demand", "collapse", "citation"})
        states: list[LimitState] = []
        for name, state in self.states.items():
            dispersion = self.dispersion if state.dispersion is None else state.dispersion
            if dispersion is None:
                text = "is missing; give it here or for all states of the entry"
                raise InputError(f"{where}: states.{name}.dispersion: {text}")
            common["degree"] = None if self.degrees is None else self.degrees.get(name, "")
            capacity = {"threshold": state.median * factor, "dispersion": dispersion}
            states.append(LimitState(name=name, unit=unit, **capacity, **common))
        return states


def load_limit_states(path: Path) -> list[LimitState]:
    """Read limit states from a YAML file; an `InputError` names wrong entries and keys."""
    return limit_states_of(read_yaml(path), f"{shown_path(path)}: ")


def limit_states_of(data: object, prefix: str = "") -> list[LimitState]:
    """Return the limit states of a parsed file; an `InputError` names wrong entries."""
    if not isinstance(data, list) or not data:
        raise InputError(f"{prefix}limit states must be a list with at least one entry")
    states: list[LimitState] = []
    faults: list[InputError] = []
    for row, entry in enumerate(data, start=1):
        where = f"{prefix}limit state entry {row}"
        try:
            states += checked(LimitStateEntry, entry, where).limit_states(where)
        except InputError as error:
            faults.append(error)
    repeated = (key for key, count in Counter(state.key for state in states).items() if count > 1)
    faults += [InputError(f"{prefix}limit state {key} is defined twice") for key in repeated]
    raise_all(faults)
    return states


def demand_unit(column: str, state_unit: str = "ratio") -> str:
    """Return the unit of a demand, such as ``m``; ``state_unit`` is the unit of its limit states.

    It is in `demands/columns.csv`, or ends the name of a foreign column.
    """
    if (entry := column_of(column)) is not None:
        return _spelled(entry.unit)
    if column.lower().endswith(f"_{state_unit}"):
        return state_unit
    if (unit := _spelled(column.rsplit("_", 1)[-1])) in _UNITS:
        return unit
    if state_unit in _UNITS and _UNITS[state_unit][0] == "ratio":
        return "ratio"
    problem = f"column {shortened(column)} does not end with a unit"
    raise InputError(f"{problem}; known units: {', '.join(_UNITS)}", column=column)


def _spelled(unit: str) -> str:
    """Return a unit as names of columns spell it: ``kN s`` as ``kns``, ``m/s2`` as ``mps2``."""
    text = unit.lower().replace(" ", "").replace("/", "p")
    return {"-": "ratio", "%": "percent"}.get(text, text)

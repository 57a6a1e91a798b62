"""What a contact unit tells its user, and how a user function drives its parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, Final, Literal

from skewbridge.errors import InputError

type Scheme = Literal["vector", "componentwise", "elastic"]
type Coupling = Literal["extrapolated", "lagged"]

DRIVEN_PARAMETERS: Final = (
    "friction",
    "cohesion_n",
    "kn_n_per_m",
    "kt_n_per_m",
    "gap_closing_m",
    "dashpot_n_s_per_m",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitState:
    """State of a unit at the end of the last committed step.

    Attributes:
        is_closed: The pair is in compression.
        opening_m: Gap plus relative displacement along the normal, negative when closed.
        opening_rate_mps: Mean over the last step, negative when approaching.
        normal_n: Compression.
        tangential_n: Friction forces along t1 and t2, with the sign of slip.
        slip_m: Stick point along t1 and t2 (the position itself while open).
        position_m: Relative tangential displacement along t1 and t2.
        slip_speed_mps: Speed of the stick point in the last step.
        slip_path_m: Length of the way slipped under friction so far.
        slip_work_j: Energy dissipated by slip so far.
        approach_speed_mps: Closing speed at the last closing of the pair.
        dt_s: Length of the coming step.
    """

    is_closed: bool
    opening_m: float
    opening_rate_mps: float
    normal_n: float
    tangential_n: tuple[float, float]
    slip_m: tuple[float, float]
    position_m: tuple[float, float]
    slip_speed_mps: float
    slip_path_m: float
    slip_work_j: float
    approach_speed_mps: float
    dt_s: float

    @property
    def penetration_m(self) -> float:
        """Negative opening, zero while open."""
        return max(0.0, -self.opening_m)

    @property
    def predicted_opening_m(self) -> float:
        """Opening at the end of the coming step, linear in time."""
        return self.opening_m + self.opening_rate_mps * self.dt_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """Tracked state of all units at one time; opaque to the caller."""

    units: list[dict[str, Any]]
    time_s: float
    dt_s: float


type DriveFunction = Callable[[UnitState, float], Mapping[str, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A user function of state and time that sets parameters of a unit after every step.

    Temperature, creep, wear, speed: whatever changes a contact slowly or quickly. What the
    function returns acts in the coming step. An example, a joint that a season closes by 20 mm in
    100 s of analysis time, while wear takes 0.1 of friction per metre slipped::

        def season(state: UnitState, time_s: float) -> dict[str, float]:
            return {
                "gap_closing_m": 0.020 * min(1.0, time_s / 100.0),
                "friction": max(0.3, 0.5 - 0.1 * state.slip_path_m),
            }

        contacts.add(..., drive=Drive(parameters=("gap_closing_m", "friction"), function=season))

    Attributes:
        parameters: Names it will set, of `DRIVEN_PARAMETERS`.
        function: Called with the state of the unit and the time of the set; returns new values
            for some or all of the declared parameters.

    Raises:
        InputError: An unknown name.
    """

    parameters: tuple[str, ...]
    function: DriveFunction

    def __post_init__(self) -> None:
        for name in self.parameters:
            if name not in DRIVEN_PARAMETERS:
                raise InputError(f"a drive may set {', '.join(DRIVEN_PARAMETERS)}; got {name!r}")

    def values(self, state: UnitState, time_s: float) -> Mapping[str, float]:
        """Call the function and check what it returns.

        Raises:
            InputError: An undeclared name, or a value that is not finite or negative.
        """
        values = self.function(state, time_s)
        for name, value in values.items():
            if name not in self.parameters:
                raise InputError(
                    f"the drive declared {', '.join(self.parameters)} but returned {name!r}"
                )
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"driven {name} must be finite and not negative, got {value}")
        return values

"""State and ledger of a contact unit, and drives that set its parameters."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Final, Literal

from skewbridge.errors import InputError


@dataclass(slots=True)
class Account:
    """Running sums of one contact unit; plain numbers, added up in the step loop.

    Attributes:
        closures: Number of steps that ended closed after one that ended open.
        contact_time_s: Time spent closed.
        max_penetration_m: Largest negative opening.
        max_normal_n: Largest compression.
        max_friction_n: Largest tangential force.
        max_limit_n: Largest friction limit.
        max_violation_n: Largest excess of the tangential force over cohesion + friction x normal
            force at the end of a step.
        slip_path_m: Length of the slip path in contact.
        slip_work_j: Energy dissipated by slip, trapezoidal rule on end-of-step forces.
        normal_work_j: Work done on the normal spring (and its dashpot), the same rule.
        friction_impulse_ns: Sum of friction force times step.
        friction_work_j: Sum of end-of-step friction force times slip; the three kinds of work
            below are parts of it.
        excess_work_j: Friction work above the limit at the end of the step.
        opening_work_j: Friction work in steps in which the pair opened.
        time_over_1_s: Time with a friction force at least 1 % above its limit; ``_10`` and ``_50``
            for 10 and 50 %.
        work_over_1_j: Friction work in that time; ``_10`` and ``_50`` likewise.
    """

    closures: int = 0
    contact_time_s: float = 0.0
    max_penetration_m: float = 0.0
    max_normal_n: float = 0.0
    max_friction_n: float = 0.0
    max_limit_n: float = 0.0
    max_violation_n: float = 0.0
    slip_path_m: float = 0.0
    slip_work_j: float = 0.0
    normal_work_j: float = 0.0
    friction_impulse_ns: float = 0.0
    friction_work_j: float = 0.0
    excess_work_j: float = 0.0
    opening_work_j: float = 0.0
    time_over_1_s: float = 0.0
    time_over_10_s: float = 0.0
    time_over_50_s: float = 0.0
    work_over_1_j: float = 0.0
    work_over_10_j: float = 0.0
    work_over_50_j: float = 0.0


@dataclass(slots=True, kw_only=True)
class UnitLedger(Account):
    """Ledger of one named contact unit since it was added, with the energy in its normal spring."""

    name: str
    normal_potential_j: float

    @property
    def cone_violation_ratio(self) -> float:
        """Largest excess over the largest friction limit of the run.

        The excess is at most friction times the error of the predicted normal force.
        """
        return self.max_violation_n / self.max_limit_n if self.max_limit_n > 0.0 else 0.0


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
        slip_path_m: Length of the slip path under friction so far.
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


type DriveFunction = Callable[[UnitState, float], Mapping[str, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A user function of state and time that sets parameters of a unit after every step.

    It can model effects of temperature, creep, wear or speed. The returned values act in the
    coming step. Example: temperature closes a joint by 20 mm in 100 s of analysis time, and wear
    reduces the friction by 0.1 per metre of slip::

        def season(state: UnitState, time_s: float) -> dict[str, float]:
            return {
                "gap_closing_m": 0.020 * min(1.0, time_s / 100.0),
                "friction": max(0.3, 0.5 - 0.1 * state.slip_path_m),
            }

        contacts.add(..., drive=Drive(parameters=("gap_closing_m", "friction"), function=season))

    Attributes:
        parameters: Names of the parameters that it sets, from `DRIVEN_PARAMETERS`.
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
        """Call the function; `InputError` for an undeclared name or an impossible value."""
        values = self.function(state, time_s)
        for name, value in values.items():
            if name not in self.parameters:
                raise InputError(
                    f"the drive declared {', '.join(self.parameters)} but returned {name!r}"
                )
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"driven {name} must be finite and not negative, got {value}")
        return values

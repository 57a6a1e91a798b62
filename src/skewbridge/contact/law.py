"""Law of a contact pair: Coulomb friction with cohesion, unilateral contact, drives and ledger.

Signs: `opening_m` is positive while the pair is apart, `normal_n` is positive in compression, and
the tangential force has the sign of the slip (it is the spring force; the force on the moving body
is opposite). Pairs of values are along the two directions of the contact plane (the second is
zero in plane models). `ContactUnit` uses the yields of this module and repeats its other formulas
for speed; checks compare it with these.

References:
    Rahman and Mackie (2023), Finite Elements in Analysis and Design 218 (parameter updates);
    Simo and Hughes (1998), Computational Inelasticity, chapter 2 (return mapping).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import hypot, isfinite, sqrt
from typing import Final, Literal, NamedTuple

from skewbridge.errors import InputError

type Scheme = Literal["vector", "componentwise", "elastic"]
type Coupling = Literal["extrapolated", "lagged"]


def require_limits(name: str, value: float, *, is_positive: bool = False) -> None:
    """Raise `InputError` if a value is negative, not finite, or zero where it must be positive."""
    if not (isfinite(value) and value >= 0.0 and (value or not is_positive)):
        kind = "positive" if is_positive else "not negative"
        raise InputError(f"{name} must be finite and {kind}, got {value}")


# ASSUME Coulomb friction, static equal to kinetic, the same in all directions of the contact plane.
# ASSUME the contact itself is elastic: restitution comes from a driven damper only.
@dataclass(frozen=True, slots=True)
class ContactLaw:
    """Parameters of a contact pair; `InputError` for a value outside its limits."""

    kn_n_per_m: float  #: normal penalty
    kt_n_per_m: float  #: tangential penalty
    friction: float = 0.0  #: Coulomb coefficient
    cohesion_n: float = 0.0  #: friction limit at zero normal force, while the pair is closed
    gap_m: float = 0.0  #: initial opening

    def __post_init__(self) -> None:
        for name in ("kn_n_per_m", "kt_n_per_m"):
            require_limits(name, getattr(self, name), is_positive=True)
        for name in ("friction", "cohesion_n", "gap_m"):
            require_limits(name, getattr(self, name))


def friction_limit_n(normal_n: float, friction: float, cohesion_n: float) -> float:
    """Return the friction limit in N; zero while open, so that cohesion acts only in contact."""
    return cohesion_n + friction * normal_n if normal_n > 0.0 else 0.0


def radial_return(
    offset_1_m: float, offset_2_m: float, kt_n_per_m: float, limit_n: float
) -> tuple[float, float]:
    """Return the tangential force in N for an offset from the stick point, limited to the cone.

    After slip, the new stick point is the position minus force / kt.
    """
    trial_1, trial_2 = kt_n_per_m * offset_1_m, kt_n_per_m * offset_2_m
    trial_n = hypot(trial_1, trial_2)
    if trial_n <= limit_n:
        return trial_1, trial_2
    scale = limit_n / trial_n
    return scale * trial_1, scale * trial_2


class PairState(NamedTuple):
    """State of a pair at the end of a step; forces have the sign of slip and are zero if open."""

    normal_n: float
    force_n: tuple[float, float]
    stick_m: tuple[float, float]
    is_slipping: bool


def advance_pair(
    law: ContactLaw, stick_m: tuple[float, float], position_m: tuple[float, float], opening_m: float
) -> PairState:
    """Return the state after a step from the normal force at its end (exact discrete law).

    ``stick_m`` is the stick point at the end of the last step; ``position_m`` and ``opening_m``
    (including the gap) are values at the end of this step.
    """
    if opening_m >= 0.0:
        return PairState(0.0, (0.0, 0.0), position_m, is_slipping=False)
    normal, kt = -law.kn_n_per_m * opening_m, law.kt_n_per_m
    limit = friction_limit_n(normal, law.friction, law.cohesion_n)
    offset_1, offset_2 = position_m[0] - stick_m[0], position_m[1] - stick_m[1]
    force_1, force_2 = radial_return(offset_1, offset_2, kt, limit)
    is_slipping = kt * hypot(offset_1, offset_2) > limit
    slid_m = position_m[0] - force_1 / kt, position_m[1] - force_2 / kt
    return PairState(normal, (force_1, force_2), slid_m if is_slipping else stick_m, is_slipping)


def yields_on_cone(trial_1_n: float, trial_2_n: float, limit_n: float) -> tuple[float, float]:
    """Return the yield forces of two separate springs that together stay inside the cone.

    The pair of yields lies on the cone. For a trial force outside the cone it is the point of
    radial return. Inside the cone, both yields exceed the components of the trial by the same
    slack, so that a component near zero does not make a sticking pair slip.
    """
    abs_1, abs_2 = abs(trial_1_n), abs(trial_2_n)
    trial_n = hypot(abs_1, abs_2)
    if trial_n >= limit_n:
        scale = limit_n / trial_n if trial_n > 0.0 else 0.0
        return scale * abs_1, scale * abs_2
    mean = 0.5 * (abs_1 + abs_2)
    slack = sqrt(mean * mean + 0.5 * (limit_n * limit_n - trial_n * trial_n)) - mean
    # Rounding can make a slack near zero negative; a yield below the trial would cause slip.
    slack = max(slack, 0.0)
    return abs_1 + slack, abs_2 + slack


def yields_by_direction(trial_1_n: float, trial_2_n: float, limit_n: float) -> tuple[float, float]:
    """Return the yields as the direction cosines of the trial times the limit (the paper)."""
    trial_n = hypot(trial_1_n, trial_2_n)
    if trial_n == 0.0:
        equal_yield_n = limit_n * sqrt(0.5)
        return equal_yield_n, equal_yield_n
    return limit_n * abs(trial_1_n) / trial_n, limit_n * abs(trial_2_n) / trial_n


# --- drives and ledger

DRIVEN_PARAMETERS: Final = (
    "friction", "cohesion_n", "kn_n_per_m", "kt_n_per_m", "dashpot_n_s_per_m"
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitState:
    """State of a unit at the end of the last committed step."""

    opening_m: float  #: gap plus relative displacement along the normal, negative when closed
    opening_rate_mps: float  #: mean over the last step, negative when approaching
    normal_n: float  #: compression
    tangential_n: tuple[float, float]  #: along t1 and t2, with the sign of slip
    slip_m: tuple[float, float]  #: stick point along t1 and t2 (the position itself while open)
    position_m: tuple[float, float]  #: relative tangential displacement along t1 and t2
    slip_speed_mps: float  #: speed of the stick point in the last step
    slip_path_m: float  #: length of the slip path under friction so far
    slip_work_j: float  #: energy dissipated by slip so far
    dt_s: float  #: length of the coming step

    @property
    def predicted_opening_m(self) -> float:
        """Opening at the end of the coming step, extrapolated linearly."""
        return self.opening_m + self.opening_rate_mps * self.dt_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """A user function of state and time that sets parameters of a unit for the coming step.

    Example: wear reduces the friction by 0.1 per metre of slip::

        def worn(state: UnitState, time_s: float) -> dict[str, float]:
            return {"friction": max(0.3, 0.5 - 0.1 * state.slip_path_m)}

        contacts.add(..., drive=Drive(parameters=("friction",), function=worn))

    The parameters are names in `DRIVEN_PARAMETERS` (`InputError` otherwise). The function gets the
    state and the sum of all steps in s; it returns new values of some of these parameters.
    """

    parameters: tuple[str, ...]
    function: Callable[[UnitState, float], Mapping[str, float]]

    def __post_init__(self) -> None:
        for name in self.parameters:
            if name not in DRIVEN_PARAMETERS:
                raise InputError(f"a drive may set {', '.join(DRIVEN_PARAMETERS)}; got {name!r}")

    def values(self, state: UnitState, time_s: float) -> Mapping[str, float]:
        """Return the function's values; raise `InputError` if a name or value is not allowed."""
        values = self.function(state, time_s)
        for name, value in values.items():
            if name not in self.parameters:
                raise InputError(
                    f"the drive declared {', '.join(self.parameters)} but returned {name!r}"
                )
            require_limits(f"driven {name}", value)
        return values


@dataclass(slots=True)
class UnitLedger:
    """Running sums and extremes of one contact unit since it was added, at the ends of steps."""

    name: str
    closures: int = 0  #: steps that end closed after a step that ended open
    contact_time_s: float = 0.0
    max_penetration_m: float = 0.0
    max_friction_n: float = 0.0
    max_limit_n: float = 0.0  #: largest friction limit: cohesion + friction x normal
    max_violation_n: float = 0.0  #: largest excess of the friction force over its limit
    slip_path_m: float = 0.0
    slip_work_j: float = 0.0  #: energy dissipated by slip (trapezoidal rule)
    normal_work_j: float = 0.0  #: work on normal spring and dashpot (trapezoidal rule)
    friction_impulse_ns: float = 0.0  #: sum of friction force times step
    friction_work_j: float = 0.0  #: sum of friction force times slip
    excess_work_j: float = 0.0  #: part of the friction work from force above the limit
    work_over_10_j: float = 0.0  #: friction work with a force over 10 % above its limit
    normal_potential_j: float = 0.0  #: energy in the normal spring when the ledger is read

    @property
    def cone_violation_ratio(self) -> float:
        """Largest excess of friction over its limit, divided by the largest limit."""
        return self.max_violation_n / self.max_limit_n if self.max_limit_n > 0.0 else 0.0

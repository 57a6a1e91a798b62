"""Drives for other laws of friction and normal contact, and coefficients of restitution.

Values outside their limits raise `InputError`. A drive acts in the coming step, so it uses the
opening predicted for the end of that step. Its error is of second order in the time step during
contact, and of first order when contact begins or ends.
"""

from functools import partial
from math import atan2, exp, log, sqrt

from scipy.optimize import brentq

from skewbridge.contact.law import Drive, UnitState, require_limits
from skewbridge.errors import InputError

_LARGEST_DAMPING_RATIO = 1.0e4


def stribeck_friction(
    slip_speed_mps: float,
    *,
    static: float,
    kinetic: float,
    stribeck_speed_mps: float,
    viscous_s_per_m: float = 0.0,
) -> float:
    """Return the coefficient kinetic + (static - kinetic) exp(-(v / v_s)^2) + viscous v.

    References:
        Armstrong-Helouvry, Dupont and Canudas de Wit (1994), Automatica 30.
    """
    decay = exp(-((slip_speed_mps / stribeck_speed_mps) ** 2))
    return kinetic + (static - kinetic) * decay + viscous_s_per_m * slip_speed_mps


def stribeck_drive(
    *, static: float, kinetic: float, stribeck_speed_mps: float, viscous_s_per_m: float = 0.0
) -> Drive:
    """Return a drive that sets the friction coefficient from the slip speed of the last step."""
    if not 0.0 <= kinetic <= static:
        raise InputError(
            f"friction must be 0 <= kinetic <= static, got kinetic {kinetic}, static {static}"
        )
    require_limits("stribeck_speed_mps", stribeck_speed_mps, is_positive=True)
    speeds = {"stribeck_speed_mps": stribeck_speed_mps, "viscous_s_per_m": viscous_s_per_m}
    coefficient_at = partial(stribeck_friction, static=static, kinetic=kinetic, **speeds)

    def friction(state: UnitState, _time_s: float) -> dict[str, float]:
        return {"friction": coefficient_at(state.slip_speed_mps)}

    return Drive(parameters=("friction",), function=friction)


def kelvin_voigt_drive(*, kn_n_per_m: float, dashpot_n_s_per_m: float) -> Drive:
    """Return a drive for a normal spring with a dashpot, whose total force is never tensile.

    The force of the dashpot jumps when the pair closes within a step. In that step its coefficient
    is multiplied by 0.5 + the share of the step after closing, which gives the correct impulse.
    When the total would be tensile, spring and dashpot are switched off until the pair opens or
    approaches again, as `kelvin_voigt_restitution` assumes.
    """
    require_limits("kn_n_per_m", kn_n_per_m, is_positive=True)
    require_limits("dashpot_n_s_per_m", dashpot_n_s_per_m)

    def spring_and_dashpot(state: UnitState, _time_s: float) -> dict[str, float]:
        opening, rate = state.opening_m, state.opening_rate_mps
        predicted_m = state.predicted_opening_m
        if predicted_m >= 0.0:
            # The spring remains, in case the pair stays closed.
            return {"kn_n_per_m": kn_n_per_m, "dashpot_n_s_per_m": 0.0}
        if kn_n_per_m * predicted_m + dashpot_n_s_per_m * rate >= 0.0:
            return {"kn_n_per_m": 0.0, "dashpot_n_s_per_m": 0.0}
        dashpot_factor = 1.0 if opening <= 0.0 else 0.5 + predicted_m / (predicted_m - opening)
        return {"kn_n_per_m": kn_n_per_m, "dashpot_n_s_per_m": dashpot_factor * dashpot_n_s_per_m}

    return Drive(parameters=("kn_n_per_m", "dashpot_n_s_per_m"), function=spring_and_dashpot)


def kelvin_voigt_restitution(damping_ratio: float) -> float:
    """Return the rebound / approach speed ratio of a Kelvin-Voigt contact without tension.

    It exceeds the textbook value, in which the dashpot pulls the bodies before they separate.

    References:
        Schwager and Poeschel (2007), Granular Matter 9 (end of contact at zero force).
    """
    z = damping_ratio
    require_limits("damping_ratio", z)
    if z < 1.0:
        root = sqrt(1.0 - z * z)
        return exp(-z / root * atan2(2.0 * z * root, 2.0 * z * z - 1.0)) if z > 0.0 else 1.0
    if z == 1.0:
        return exp(-2.0)
    root = sqrt(z * z - 1.0)
    return exp(-2.0 * z / root * log(z + root))


def kelvin_voigt_damping_ratio(restitution: float) -> float:
    """Return the damping ratio for a restitution in (0, 1], without tension in the contact."""
    if not 0.0 < restitution <= 1.0:
        raise InputError(f"restitution must be above 0 and at most 1, got {restitution}")
    if restitution == 1.0:
        return 0.0
    damping_ratios = 0.0, _LARGEST_DAMPING_RATIO
    return brentq(lambda z: kelvin_voigt_restitution(z) - restitution, *damping_ratios, xtol=1e-14)

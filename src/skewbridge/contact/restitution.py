"""Coefficients of restitution of damped contacts whose force is clipped at zero (no tension).

The textbook relation of the Kelvin-Voigt model assumes that the dashpot may pull the bodies
together before they separate. With the force clipped at zero the rebound is faster, so the same
restitution needs more damping.

References:
    Schwager and Poeschel (2007), Granular Matter 9 (end of contact at zero force);
    Hunt and Crossley (1975), Journal of Applied Mechanics 42 (damping times penetration).
"""

from math import atan2, exp, log, sqrt

from scipy.optimize import brentq

from skewbridge.errors import InputError

_LARGEST_DAMPING_RATIO = 1.0e4


def kelvin_voigt_restitution(damping_ratio: float) -> float:
    """Return rebound over approach speed of a Kelvin-Voigt contact that carries no tension."""
    z = damping_ratio
    if z < 0.0:
        raise InputError(f"damping_ratio must not be negative, got {z}")
    if z < 1.0:
        root = sqrt(1.0 - z * z)
        return exp(-z / root * atan2(2.0 * z * root, 2.0 * z * z - 1.0)) if z > 0.0 else 1.0
    if z == 1.0:
        return exp(-2.0)
    root = sqrt(z * z - 1.0)
    return exp(-2.0 * z / root * log(z + root))


def kelvin_voigt_damping_ratio(restitution: float) -> float:
    """Return the damping ratio for a restitution in (0, 1] with the force clipped at zero."""
    _require_restitution(restitution)
    if restitution == 1.0:
        return 0.0
    return float(
        brentq(
            lambda z: kelvin_voigt_restitution(z) - restitution,
            0.0,
            _LARGEST_DAMPING_RATIO,
            xtol=1e-14,
        )
    )


def hunt_crossley_damping(restitution: float) -> float:
    """Return d of F = k x^p (1 + d / v0 x') for a restitution in (0, 1], for any exponent p.

    Solves ln((1 + d) / (1 - e d)) = d (1 + e) for the approach speed v0. The force becomes zero
    together with the penetration or later, so nothing has to be clipped before separation.
    """
    _require_restitution(restitution)
    if restitution == 1.0:
        return 0.0
    e = restitution

    def residual(d: float) -> float:
        return log((1.0 + d) / (1.0 - e * d)) - d * (1.0 + e)

    # Zero is also a root; the residual is negative just above it and infinite at d = 1 / e.
    return float(brentq(residual, 1e-3 * (1.0 - e), (1.0 - 1e-15) / e, xtol=1e-14))


def _require_restitution(restitution: float) -> None:
    if not 0.0 < restitution <= 1.0:
        raise InputError(f"restitution must be within 0 < e <= 1, got {restitution}")

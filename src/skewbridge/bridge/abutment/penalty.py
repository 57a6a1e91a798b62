"""Contact penalties by rule, from the stiffness and the mass of what stands behind a contact."""

from skewbridge.variant.options import ModelOptions

# A penalty 50 times its neighbour softens the two in series by 2 %.
NORMAL_OVER_NEIGHBOUR = 50.0
# ASSUME with wall_mass the contact's own frequency may reach 3 rad per step of 5 ms, the paper's:
# with Houbolt at that step and OSB1 at zero skew, demands moved by 5 % at 4.6 rad when the motion
# changed by a millionth, and by a millionth at 3.2.
NOMINAL_STEP_S = 0.005
MAX_RADIANS_PER_STEP = 3.0
# ASSUME sticking is resolved 5 times softer than contact: a much softer spring does not reach the
# limit within a short contact, so that friction depends on the time step; a stiffer one makes
# friction start where nothing slides. results/sensitivity.parquet halves and doubles it.
NORMAL_OVER_TANGENT = 5.0


def normal_penalty(neighbour_n_per_m: float, mass_kg: float, options: ModelOptions) -> float:
    """Return the normal penalty of a contact in N/m, unless the options name one.

    The neighbour is the stiffest spring in series with the contact, the mass that of the node
    between them; a node without mass sets no limit.
    """
    factor = options.normal_stiffness_factor
    if options.normal_stiffness_n_per_m is not None:
        return factor * options.normal_stiffness_n_per_m
    stiff = NORMAL_OVER_NEIGHBOUR * neighbour_n_per_m
    if mass_kg > 0.0:
        stiff = min(stiff, mass_kg * (MAX_RADIANS_PER_STEP / NOMINAL_STEP_S) ** 2)
    return factor * stiff


def tangent_penalty(normal_n_per_m: float, options: ModelOptions) -> float:
    """Return the tangential penalty of a contact in N/m, from its normal penalty."""
    factor = options.tangent_stiffness_factor
    if options.tangent_stiffness_n_per_m is not None:
        return factor * options.tangent_stiffness_n_per_m
    return factor * normal_n_per_m / options.normal_stiffness_factor / NORMAL_OVER_TANGENT

"""Contact penalties by rule, from the stiffness of what stands behind a contact."""

from skewbridge.bridge.options import ModelOptions

# A penalty 50 times its neighbour softens the two in series by 2 %.
NORMAL_OVER_NEIGHBOUR = 50.0
# ASSUME sticking is resolved 20 times softer than contact: measured on OSB1 under recorded
# motions, demands move by less than 0.3 % for 4 times softer to 10 times stiffer, while from
# 5e8 N/m per point on Newton's method cycles between stick and slip.
NORMAL_OVER_TANGENT = 20.0


def normal_penalty(neighbour_n_per_m: float, options: ModelOptions) -> float:
    """Return the normal penalty of a contact in N/m, from its stiffest neighbour in series."""
    by_rule = NORMAL_OVER_NEIGHBOUR * neighbour_n_per_m
    return options.normal_stiffness_factor * (options.normal_stiffness_n_per_m or by_rule)


def tangent_penalty(normal_n_per_m: float, options: ModelOptions) -> float:
    """Return the tangential penalty of a contact in N/m, from its normal penalty at factor 1."""
    by_rule = normal_n_per_m / options.normal_stiffness_factor / NORMAL_OVER_TANGENT
    return options.tangent_stiffness_factor * (options.tangent_stiffness_n_per_m or by_rule)

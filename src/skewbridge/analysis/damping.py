"""Rayleigh damping of deck and columns on the committed stiffness."""

from math import pi

import openseespy.opensees as ops

from skewbridge.bridge.catalogue import BridgeData
from skewbridge.bridge.handles import BridgeModel
from skewbridge.variant.options import ModelOptions


def damping_ratio(bridge: BridgeData, options: ModelOptions) -> float:
    """Return the ratio of the options, or that of the bridge's file where they give none."""
    return bridge.damping.ratio if options.damping_ratio is None else options.damping_ratio


def rayleigh_factors(bridge: BridgeData, ratio: float) -> tuple[float, float]:
    """Return a0 (1/s) and a1 (s) that give a damping ratio at the two periods of a bridge."""
    data = bridge.damping
    low, high = 2 * pi / data.long_period_s, 2 * pi / data.short_period_s
    return 2 * ratio * low * high / (low + high), 2 * ratio / (low + high)


def apply_rayleigh(model: BridgeModel) -> tuple[float, float]:
    """Damp deck and columns, and nothing else: penalty springs and gaps stay undamped.

    The mass part acts on the nodes of the region's elements, so wall and key nodes have none.

    Returns:
        The factors, for the energy balance.
    """
    a0, a1 = rayleigh_factors(model.bridge, damping_ratio(model.bridge, model.options))
    factors = (a0, 0.0, 0.0, a1)
    ops.region(model.tags.region(), "-ele", *model.damping_elements, "-rayleigh", *factors)
    return a0, a1

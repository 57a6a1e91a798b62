"""Periods of a bridge of the catalogue whose file does not give them, from its OpenSees model."""

from math import isinf, sqrt
from os import devnull
from typing import Literal

import openseespy.opensees as ops

from skewbridge.bridge.assembly import assemble, domain
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.gravity import GravityError
from skewbridge.bridge.modes import modes_of, period_s
from skewbridge.bridge.structures import CatalogueBridge
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

_MODES = 14


def bridge_period_s(bridge: BridgeData, which: Literal["t1", "long", "short"]) -> float:
    """Return the conditioning period, or the long or short period of Rayleigh damping, in s.

    T1 is that of the model with pads, open gaps and zero skew. The periods of damping are those of
    cracked columns on rollers, for the short one with ends held transversely; a bridge without
    columns has no longitudinal stiffness without its pads. Raises `ValueError` for a
    mechanism, or if the domain has a model, which would be lost.
    """
    if ops.getNodeTags():
        raise ValueError("the domain is in use")
    is_free = which != "t1" and bool(bridge.bents)
    values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": 0}
    variant = Variant.at(bridge.name, "roller" if is_free else "contact_friction", values)
    ops.logFile(devnull, "-noEcho")
    try:
        with domain():
            build = CatalogueBridge(bridge).build
            model = assemble(build, variant, ModelOptions(elastic_columns=is_free))
            if is_free and which == "short":
                for end in model.frame.ends:
                    ops.fix(end.node, 0, 1, 0, 0, 0, 0)
            modes = modes_of(model, _MODES)
    except GravityError as error:
        raise ValueError(error) from error
    finally:
        ops.model("basic", "-ndm", 3, "-ndf", 6)  # of a domain in which a bridge is loaded
    x_s, y_s, z_s = (period_s(modes, axis) for axis in "xyz")
    if isinf(x_s + y_s + z_s):
        raise ValueError("the bridge is a mechanism")
    if which == "t1":
        return sqrt(x_s * y_s)
    return max(x_s, y_s) if which == "long" else min(y_s, z_s)

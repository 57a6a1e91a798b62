"""
Model of a bridge
=================

Plan, elevation and contacts of osb1 at a skew of 30 degrees.
"""

from skewbridge.bridge.model import model_geometry
from skewbridge.report.bridge_figures import model_figure
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": 30.0}
variant = Variant.at("osb1", "contact_friction", values)
figure = model_figure(model_geometry(variant, ModelOptions()))

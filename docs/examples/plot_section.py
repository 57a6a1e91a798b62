"""
Column section
==============

Moment and curvature with the idealised plastic hinge, and shear strength over ductility.
"""

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import shear_section
from skewbridge.bridge.gravity import column_axial_n
from skewbridge.bridge.hinge import shear_span_m
from skewbridge.bridge.moment_curvature import section_response
from skewbridge.report.bridge_figures import column_figure

bridge = load_bridge("osb1_fixed")
axial_n = column_axial_n(bridge, 0)
curve = section_response(bridge.column, axial_n)
shear = shear_section(bridge.column, shear_span_m(bridge, 0), curve)
figure = column_figure(curve, shear, axial_n, title=bridge.title)

"""
Column section
==============

Moment-curvature relation with its idealisation, and shear strength against ductility.
"""

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.report.bridge_figures import column_figure

bridge = load_bridge("osb1_fixed")
bent = bent_capacity(bridge, 0)
figure = column_figure(bent.curve, bent.shear, bent.axial_n, title=bridge.title)

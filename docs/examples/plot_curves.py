"""
Fragility curves
================

Curves of a component by the axis with the largest effect, with bands and the runs of the fits.
"""

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.report.fragility_figures import curves_figure, pooled_curves

study = skewbridge.load(DEMO_STUDY)
curves = study.fragility["curves"]
table = pooled_curves(curves, study.fragility["median_effects"])
figure = curves_figure(table[table["component"] == "column_shear"], curves, study.demands)

"""
Fragility curves
================

Curves of a component with their bands, and the paired ratios of their medians.
"""

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.report.fragility_figures import fragility_curves

study = skewbridge.load(DEMO_STUDY)
curves, medians = study.fragility["curves"], study.fragility["median_effects"]
figure = fragility_curves(curves, study.demands, medians, "column_shear")

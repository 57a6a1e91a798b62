"""
Fragility curves
================

Curves of a component with their confidence bands, and the runs used in the fits.
"""

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.report.fragility_figures import fragility_curves

study = skewbridge.load(DEMO_STUDY)
figure = fragility_curves(study.fragility["curves"], study.demands, "column_shear")

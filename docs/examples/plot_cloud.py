"""
Demands against intensity
=========================

One marker per analysis. Lines are cloud fits; dotted lines are limit states.
"""

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.report.fragility_figures import demand_clouds

study = skewbridge.load(DEMO_STUDY)
figure = demand_clouds(study.demands, study.fragility["curves"], "column_shear_dcr")

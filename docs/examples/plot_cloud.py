"""
Demands against intensity
=========================

One marker per analysis, coloured by the axis with the largest effect. Lines are mean cloud fits;
dotted lines are limit states.
"""

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.report.fragility_figures import demand_clouds

study = skewbridge.load(DEMO_STUDY)
tables = study.fragility
figure = demand_clouds(study.demands, tables["curves"], tables["effects"], "column_shear_dcr")

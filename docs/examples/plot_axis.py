"""
Medians by variant
==================

Median capacity of each variant with its interval.
"""

import matplotlib.pyplot as plt

import skewbridge
from skewbridge.cli.study import DEMO_STUDY

curves = skewbridge.load(DEMO_STUDY).fragility["curves"]
state = curves.query("preferred and component == 'column_shear' and limit_state == 'dcr_050'")
names = [
    f"skew {row.skew_deg:g}°, gap {row.gap_mm:g} mm, μ {row.friction:g}"
    for row in state.itertuples()
]
plt.hlines(names, state["theta_low"], state["theta_high"], color="grey")
plt.plot(state["theta"], names, "o")
plt.xlabel("median Sa,avg of column shear, DCR 0.50 (g)")
plt.tight_layout()

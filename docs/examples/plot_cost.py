"""
Cost of the analyses
====================

Processor time of each analysis against its intensity.
"""

import matplotlib.pyplot as plt

import skewbridge
from skewbridge.cli.study import DEMO_STUDY

demands = skewbridge.load(DEMO_STUDY).demands
for friction, rows in demands.groupby("friction"):
    plt.semilogx(rows["im_saavg_rotd50_g"], rows["cpu_s"], "o", label=f"friction {friction:g}")
plt.xlabel("Sa,avg (g)")
plt.ylabel("processor time (s)")
plt.ylim(bottom=0.0)
plt.legend()

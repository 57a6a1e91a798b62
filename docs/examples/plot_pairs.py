"""
Paired comparison
=================

Ratio of demands with and without friction under the same motion, without the scatter
between motions.
"""

import matplotlib.pyplot as plt

import skewbridge
from skewbridge.cli.study import DEMO_STUDY

demands = skewbridge.load(DEMO_STUDY).demands.query("complete")
keys = ["bridge", "skew_deg", "gap_mm", "motion_id", "incidence_deg", "im_saavg_rotd50_g"]
paired = demands.pivot_table("deck_disp_m", keys, "friction").dropna()
ratio = (paired[0.5] / paired[0.0]).reset_index(name="ratio")
for skew_deg, rows in ratio.groupby("skew_deg"):
    plt.semilogx(rows["im_saavg_rotd50_g"], rows["ratio"], "o", label=f"skew {skew_deg:g}°")
plt.axhline(1.0, color="grey", lw=0.8)
plt.xlabel("Sa,avg (g)")
plt.ylabel("deck displacement, friction 0.5 over 0")
plt.legend()

"""
Backfill behind the backwall
============================

Passive force against closure of the joint for three skews.
"""

import matplotlib.pyplot as plt
import numpy as np

from skewbridge.bridge.backfill import wall_backfill
from skewbridge.bridge.catalogue import load_bridge

closure_m = np.linspace(0.0, 0.15, 200)
for skew_deg in (0, 30, 60):
    passive = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", np.radians(skew_deg))
    plt.plot(1000 * closure_m, passive.force_n(closure_m) / 1e6, label=f"skew {skew_deg}°")
plt.xlabel("closure after contact (mm)")
plt.ylabel("force normal to the backwall (MN)")
plt.legend()

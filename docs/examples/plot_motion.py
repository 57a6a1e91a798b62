"""
Spectra of a motion
===================

Spectra of both components of a synthetic motion and their RotD50, at 5 % damping.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from skewbridge.motions.intensity import component_psa, pair_psa
from skewbridge.motions.read import read_motion
from skewbridge.study.folder import starter_files

folder = Path(starter_files()) / "motions" / "synthetic"
motion = read_motion(folder / "syn002_h1.AT2", folder / "syn002_h2.AT2")
periods_s = np.geomspace(0.05, 5.0, 80)
for number, accel in enumerate((motion.accel_1_mps2, motion.accel_2_mps2), start=1):
    psa = component_psa(accel, motion.dt_s, periods_s) / 9.80665
    plt.loglog(periods_s, psa, lw=1, label=f"component {number}")
both = pair_psa(motion.accel_1_mps2, motion.accel_2_mps2, motion.dt_s, periods_s)
plt.loglog(periods_s, both.rotd50_mps2 / 9.80665, "k", label="RotD50")
plt.xlabel("period (s)")
plt.ylabel("pseudo-acceleration (g)")
plt.legend()

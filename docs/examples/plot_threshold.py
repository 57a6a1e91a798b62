"""
Curves for other thresholds
===========================

A cloud fit gives the curve for any threshold of its demand, here column shear.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import norm

import skewbridge
from skewbridge.cli.study import DEMO_STUDY

curves = skewbridge.load(DEMO_STUDY).fragility["curves"]
fit = curves.query("demand == 'column_shear_dcr' and method == 'cloud' and status == 'ok'").iloc[0]
intensity_g = np.geomspace(0.1, 3.0, 200)
for threshold in (0.4, 0.5, 0.65):
    ln_theta = (np.log(threshold) - fit["ln_a"]) / fit["b"]
    beta = np.hypot(fit["beta"], fit["capacity_dispersion"] / fit["b"])
    plt.semilogx(
        intensity_g, norm.cdf((np.log(intensity_g) - ln_theta) / beta), label=f"DCR {threshold}"
    )
plt.xlabel("Sa,avg (g)")
plt.ylabel("P(DCR exceeded | Sa,avg)")
plt.title(fit["variant"])
plt.legend()

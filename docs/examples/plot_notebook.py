"""
Notebook: from motions to a curve
=================================

All steps of a study in pandas: motion, analysis, table of demands, cloud fit, curve.
Download it below as a notebook.
"""

# %%
# **A motion** and its intensity measures.
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from scipy.stats import linregress, norm

import skewbridge
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.read import read_motion
from skewbridge.study.folder import starter_files

folder = Path(starter_files()) / "motions" / "synthetic"
motion = read_motion(folder / "syn002_h1.AT2", folder / "syn002_h2.AT2")
measures = motion_measures(motion, load_bridge("osb1").t1_s)
pd.Series(measures).round(3)

# %%
# **An analysis** of one bridge under the first 4 s of this motion.
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.motions.record import SuiteMotion
from skewbridge.study.task import Task, analyse_task
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

values = {"skew_deg": 30, "gap_mm": 25, "friction": 0.5}
task = Task(
    variant=Variant.at("osb1", "contact_friction", values),
    motion=SuiteMotion(motion=motion, scale=1.0, measures=measures),
    incidence_deg=0.0,
    settings=AnalysisSettings(duration_s=4.0),
    options=ModelOptions(),
)
row = analyse_task(task, Path("/dev/null"), lambda *_: None)
pd.Series(row)[["status", "column_shear_dcr", "deck_disp_m", "unseating_m"]]

# %%
# **The demands table** of the stored study has one such row per variant and motion.
study = skewbridge.load(DEMO_STUDY)
variant = study.demands["variant"].iloc[0]
runs = study.demands.query("variant == @variant and complete")
runs[["motion_id", "scale", "im_saavg_rotd50_g", "column_shear_dcr", "status"]]

# %%
# **A cloud fit**: linear regression of ln demand on ln intensity.
im, demand = runs["im_saavg_rotd50_g"], runs["column_shear_dcr"]
fit = linregress(np.log(im), np.log(demand))
residual = np.log(demand) - fit.intercept - fit.slope * np.log(im)
scatter = np.sqrt(np.sum(residual**2) / (len(runs) - 2))
theta_g = np.exp((np.log(0.5) - fit.intercept) / fit.slope)
print(f"median {theta_g:.2f} g, dispersion {scatter / fit.slope:.2f}")

# %%
# **The curve** of DCR 0.50, and the curve of the study, which also uses lower bounds.
grid_g = np.geomspace(0.05, 3.0, 200)
values = norm.cdf(np.log(grid_g / theta_g) / (scatter / fit.slope))
plt.semilogx(grid_g, values, label="this fit")
curves = study.fragility["curves"].query("variant == @variant and limit_state == 'dcr_050'")
for _, curve in curves.query("method == 'cloud' and status == 'ok'").iterrows():
    values = norm.cdf(np.log(grid_g / curve["theta"]) / curve["beta"])
    plt.semilogx(grid_g, values, "--", label="study")
plt.xlabel("Sa,avg (g)")
plt.ylabel("P(DCR above 0.50 | Sa,avg)")
plt.legend()

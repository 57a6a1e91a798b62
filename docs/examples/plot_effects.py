"""
Effects with intervals
======================

Change of the headline demands along each axis, averaged over the other axes, with its interval.
"""

import matplotlib.pyplot as plt

import skewbridge
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.demands.columns import demands_for
from skewbridge.report.answer import change_name

effects = skewbridge.load(DEMO_STUDY).fragility["effects"]
pooled = effects[(effects["scope"] == "pooled") & effects["demand"].isin(demands_for("headline"))]
for (axis, low, high), rows in pooled.groupby(["axis", "from_value", "to_value"]):
    names = rows["demand"].str.replace("_", " ")
    change, ends = 100 * (rows["ratio"] - 1), 100 * (rows[["ci_low", "ci_high"]] - 1)
    bars = [change - ends["ci_low"], ends["ci_high"] - change]
    plt.errorbar(change, names, xerr=bars, fmt="o", capsize=3, label=change_name(axis, low, high))
plt.axvline(0.0, color="grey", lw=0.8)
plt.xlabel("change of the demand (%)")
plt.legend()
plt.tight_layout()

"""Run by pelicun's Python: what it makes of a fragility database, as JSON on the last line."""

import json
import sys

import numpy as np
import pandas as pd
from pelicun import uq
from pelicun.assessment import Assessment


def functions(path, levels):
    """By component its demand and, by limit state, the probabilities at the levels."""
    table = pd.read_csv(path, index_col=0)
    assessment = Assessment({"PrintLog": False, "Seed": 1})
    assessment.damage.load_model_parameters([path], set(table.index))
    found = {}
    for name, row in assessment.damage.ds_model.damage_params.iterrows():
        states = sorted({top for top, _ in row.index if top.startswith("LS")})
        capacities = {
            state: uq.LogNormalRandomVariable(
                "capacity", np.array([row[state, "Theta_0"], row[state, "Theta_1"]], dtype=float)
            )
            for state in states
            if row[state, "Family"] == "lognormal"
        }
        scale = assessment.calc_unit_scale_factor(table.loc[name, "Demand-Unit"])  # to its own
        points = scale * np.array(levels)
        values = {state: capacity.cdf(points).tolist() for state, capacity in capacities.items()}
        found[name] = {"demand": row["Demand", "Type"], "probabilities": values}
        found[name]["directional"] = int(row["Demand", "Directional"])
    return found


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    result = {path: functions(path, asked["levels"]) for path in asked["files"]}
    sys.stdout.write("\n" + json.dumps(result))

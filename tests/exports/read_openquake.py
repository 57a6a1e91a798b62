"""Run by OpenQuake's Python: what its engine reads from fragility models, as JSON."""

import json
import sys

import numpy as np
from openquake.hazardlib import nrml
from openquake.risklib import read_nrml, scientific  # read_nrml teaches `nrml` the models


def annual_rate(curve, hazard):
    """Annual rate of one curve, by the classical damage calculator."""
    poes = -np.expm1(-np.array(hazard["rates"]))  # in one year
    *_, p = scientific.classical_damage([curve], hazard["imls"], poes, 1.0, 1.0)
    return float(-np.log1p(-p))


def functions(path, levels, hazard):
    """Limit states, and by function its intensity measure, probabilities and annual rates."""
    model, made = nrml.to_python(path), {}
    for (imt, name), each in model.items():
        curves = list(each.build(model.limitStates))
        made[name] = {"imt": imt, "range": [each.minIML, each.maxIML]}
        made[name]["probabilities"] = [curve(np.array(levels)).tolist() for curve in curves]
        made[name]["rates"] = [annual_rate(curve, hazard) for curve in curves]
    return {"limit_states": model.limitStates, "functions": made}


if __name__ == "__main__":
    assert read_nrml
    asked = json.load(sys.stdin)
    found = {path: functions(path, asked["levels"], asked["hazard"]) for path in asked["files"]}
    json.dump(found, sys.stdout)

"""Run by OpenQuake's Python: what its engine reads from fragility models, as JSON."""

import json
import sys

import numpy as np
from openquake.hazardlib import nrml
from openquake.risklib import read_nrml  # teaches `nrml` the models


def functions(path, levels):
    """Limit states, and by function its intensity measure and the probabilities at the levels."""
    model = nrml.to_python(path)
    return {
        "limit_states": model.limitStates,
        "functions": {
            name: {
                "imt": imt,
                "range": [each.minIML, each.maxIML],
                "probabilities": [
                    curve(np.array(levels)).tolist() for curve in each.build(model.limitStates)
                ],
            }
            for (imt, name), each in model.items()
        },
    }


if __name__ == "__main__":
    assert read_nrml
    asked = json.load(sys.stdin)
    json.dump({path: functions(path, asked["levels"]) for path in asked["files"]}, sys.stdout)

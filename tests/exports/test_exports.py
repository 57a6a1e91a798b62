"""Exported curves as read by pelicun and OpenQuake.

Each has its own environment, which `make test-exports` installs."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.special import ndtr

from fragility_tables import STATES, curves_of, synthetic_demands
from skewbridge.files.tables import write_frame
from skewbridge.fragility.exports import export_curves, identifier
from skewbridge.fragility.hazard import HazardCurve

pytestmark = pytest.mark.exports

HERE = Path(__file__).parent
ENVIRONMENTS = HERE.parents[1] / ".exports"
LEVELS = [0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5]
TOLERANCE = 1e-6
IMLS = np.geomspace(0.02, 4.0, 400)  # the calculator of OpenQuake takes steps of a half level
RATES = 1e-3 * np.exp(-2.0 * np.log(IMLS / 0.2) - 0.25 * np.log(IMLS / 0.2) ** 2)
HAZARD = HazardCurve(im="", levels=IMLS, rates=RATES[None], quantiles=np.zeros(0))


@pytest.fixture(scope="module", name="curves")
def _curves(tmp_path_factory):
    demands = synthetic_demands(skews=(0, 30), gaps=(51,))
    # a name with characters and of a length that not every program accepts
    demands["variant"] = demands["variant"].replace(
        "osb1_cf_skew30_gap051_mu050", f"osb1_cf_skew30_gap051_mu050_hinge-length-m0p75_{'x' * 60}"
    )
    table = curves_of(demands, [state for state in STATES if state.demand in demands])
    path = tmp_path_factory.mktemp("study") / "curves.parquet"
    write_frame(table, path, {})
    return path


def read_by(program, files):
    """Return what a program reads from files, its own probabilities at the levels included."""
    python = ENVIRONMENTS / program / "bin" / "python"
    if not (ENVIRONMENTS / program / ".installed").is_file():
        pytest.skip(f"{program} is not installed in {ENVIRONMENTS}: make test-exports")
    asked = {"files": files, "levels": LEVELS}
    asked |= {"hazard": {"imls": IMLS.tolist(), "rates": RATES.tolist()}}
    # without it OpenQuake compiles for a minute what is not used here
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": ""}
    how = {"capture_output": True, "text": True, "check": False, "env": environment}
    command = [python, HERE / f"read_{program}.py"]
    done = subprocess.run(command, input=json.dumps(asked), **how)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def fitted(curves):
    """Return the preferred curves that have an estimate, with the dispersion that is exported."""
    table = pd.read_parquet(curves)
    table = table[table["preferred"] & (table["status"] == "ok")]
    return table.assign(b=table["beta_total"].fillna(table["beta"]))


def probabilities(row):
    return ndtr(np.log(np.array(LEVELS) / row.theta) / row.b)


def test_pelicun_gets_our_probabilities(curves, tmp_path):
    out = tmp_path / "pelicun.csv"
    export_curves(curves, "pelicun", out)
    found = read_by("pelicun", [str(out)])[str(out)]
    numbers = {}
    for component, states in pd.read_parquet(curves).groupby("component"):
        ordered = states.drop_duplicates("limit_state").sort_values("threshold")["limit_state"]
        numbers |= {(str(component), str(name)): n for n, name in enumerate(ordered, start=1)}
    expected = fitted(curves)
    assert len(expected) > 20
    assert sum(len(each["probabilities"]) for each in found.values()) == len(expected)
    assert {each["directional"] for each in found.values()} == {1}
    for row in expected.itertuples():
        state = f"LS{numbers[row.component, row.limit_state]}"
        name = identifier(f"{row.variant}.{row.component}", "A-Za-z0-9_.", 200)
        read = found[name]["probabilities"][state]
        np.testing.assert_allclose(read, probabilities(row), atol=TOLERANCE, rtol=0.0)


def test_openquake_reads_every_file_and_gets_our_probabilities(curves, tmp_path):
    report = export_curves(curves, "nrml", tmp_path / "curves.xml")
    found = read_by("openquake", report["files"])
    functions = {(name, state): (function, *values) for content in found.values()
                 for name, function in content["functions"].items()
                 for state, *values in zip(content["limit_states"], function["probabilities"],
                                           function["rates"], strict=True)}  # fmt: skip
    for model in report["models"]:
        assert found[model["file"]]["limit_states"] == model["limit_states"]
        assert len(found[model["file"]]["functions"]) == model["functions"]
    expected = fitted(curves)
    assert len(functions) == len(expected)
    for row in expected.itertuples():
        name = identifier(f"{row.variant}:{row.component}", r"A-Za-z0-9_:\-", 75)
        function, values, rate = functions[name, row.limit_state]
        assert function["imt"] == "AvgSA"
        # outside the range OpenQuake has 0 below, and no more than at its end above
        low, high = function["range"]
        inside = (np.array(LEVELS) > low) & (np.array(LEVELS) < high)
        ours = probabilities(row)
        np.testing.assert_allclose(np.array(values)[inside], ours[inside], atol=TOLERANCE, rtol=0.0)
        ours = HAZARD.rate(lambda x, row=row: ndtr((x - np.log(row.theta)) / row.b), row.b).value
        assert rate == pytest.approx(ours, rel=0.01)

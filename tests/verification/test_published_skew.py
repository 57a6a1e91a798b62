"""Effects of skew next to published ones: paired ratios of demands and factors on medians."""

import numpy as np
import pandas as pd
import pytest

from fragility_tables import runs_of_one_variant
from skewbridge.verification.studies.published import DEMANDS, WHOLE
from skewbridge.verification.studies.published_skew import (
    COMPARED,
    demand_ratios,
    hazus_factor,
    median_factors,
)


def test_factor_of_hazus_at_known_skews():
    """Hazus tables round 0.983, 0.931, 0.841 and 0.707 for 15, 30, 45 and 60 degrees."""
    factors = [hazus_factor(skew) for skew in (0, 15, 30, 45, -60)]
    assert factors == pytest.approx([1.0, 0.983, 0.931, 0.841, 0.707], abs=5e-4)


@pytest.fixture
def table():
    """Demands that grow by a fifth at skew 60 on average, under 24 motions."""
    random = np.random.default_rng(3)
    im = np.geomspace(0.05, 2.5, 24)
    parts = []
    for skew, factor in ((0, 1.0), (60, 1.2)):
        variant = f"bridge_b_cf_skew{skew:02d}_gap025_mu050"
        part = runs_of_one_variant(variant, "bridge_b", skew, im).assign(choice="none")
        for name in sorted({*COMPARED, *DEMANDS.values()}):
            scatter = np.exp(0.02 * random.standard_normal(im.size))
            part[f"{WHOLE}{name}"] = factor * 8.0 * im * scatter
        parts.append(part)
    return pd.concat(parts, ignore_index=True)


def test_demand_ratio_is_that_of_pairs_with_its_interval(table):
    found = demand_ratios(table)
    assert set(found["demand"]) == set(COMPARED)
    assert (found["skew_deg"] == 60).all()
    assert found["ratio"].to_numpy() == pytest.approx(1.2, rel=0.03)
    assert (found["ratio_low"] < 1.2 * 1.03).all()
    assert (found["ratio_high"] > 1.2 * 0.97).all()


def test_motions_without_the_demand_are_left_out(table):
    name = f"{WHOLE}abutment_passive_m"
    table.loc[(table["motion_id"] == "m00") & (table["skew_deg"] == 60), name] = 0.0
    found = demand_ratios(table).set_index("demand")
    assert found.loc["abutment_passive_m", "n_motions"] == 23
    assert found.loc["unseating_m", "n_motions"] == 24


def test_factor_on_a_median_is_the_inverse_of_a_proportional_demand(table):
    found = median_factors(table).set_index("demand")
    assert found.loc["column_curvature/moderate", "ratio"] == pytest.approx(1 / 1.2, rel=0.03)

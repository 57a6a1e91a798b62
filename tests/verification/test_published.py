"""Published curves and effects of skew: the stored table, our medians, ratios and reasons."""

import numpy as np
import pandas as pd
import pytest

from fragility_tables import runs_of_one_variant
from skewbridge.verification.studies.published import (
    COMPARED,
    DEMANDS,
    NONE,
    SYSTEM,
    WHOLE,
    Change,
    compared,
    demand_ratios,
    explanations,
    hazus_factor,
    median_factors,
    medians,
    outside,
    published_curves,
)

PUBLISHED = published_curves()


def line_error(part: pd.DataFrame, capacity: str) -> float:
    """Largest distance of ln capacity from a line of ln median."""
    x, y = np.log(part["median_g"]), np.log(part[capacity].astype(float))
    return float(np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max())


def test_medians_of_a_component_lie_on_a_line_of_its_capacities():
    """The source fits ln demand by a line; medians are printed with two or three digits."""
    parts = PUBLISHED[PUBLISHED["component"] != SYSTEM].groupby(["era", "component"])
    four = {key: part for key, part in parts if len(part) == 4}
    assert len(four) == 4
    for part in four.values():
        assert line_error(part, "capacity_of_curve") < 0.05
    # the doubt about joint opening of era 3: its own capacities do not make its curve
    assert line_error(four[3, "unseating"], "capacity") > 0.1
    keys = set(zip(PUBLISHED["era"], PUBLISHED["component"], strict=True))
    assert keys >= {(era, name) for era in (1, 3) for name in (*DEMANDS, SYSTEM)}
    assert not PUBLISHED.duplicated(["era", "component", "state"]).any()
    assert (PUBLISHED["row"].str.extract(r"CRCB\.E(\d)")[0].astype(int) == PUBLISHED["era"]).all()


def scattered_demands(slope: float = 1.0, sigma: float = 0.3) -> pd.DataFrame:
    """40 runs whose demands are the capacities of era 3 at the published medians, with scatter."""
    random = np.random.default_rng(5)
    im = np.geomspace(0.05, 2.5, 40)
    table = runs_of_one_variant("osb1_cf_skew00_gap025_mu050", "osb1", 0, im)
    table["beyond_model"] = ""
    era = PUBLISHED[(PUBLISHED["era"] == 3) & (PUBLISHED["state"] == "slight")]
    for row in era.to_dict("records"):
        if row["component"] in DEMANDS:
            capacity = row["capacity"] * (0.0254 if row["unit"] == "in" else 1.0)
            scatter = np.exp(sigma * random.standard_normal(im.size))
            table["whole_" + DEMANDS[row["component"]]] = (
                capacity * (im / row["median_g"]) ** slope * scatter
            )
    for name in DEMANDS.values():  # columns fail at once
        table[name] = 1e-3
    return table


def test_medians_of_demands_that_follow_the_published_line_are_the_published_ones():
    curves = PUBLISHED[PUBLISHED["era"] == 3]
    found = medians(curves, scattered_demands(), 3, NONE)
    table = compared(PUBLISHED, found).set_index(["component", "state"])
    slight = table.xs("slight", level="state")
    assert slight["ratio"].drop(SYSTEM).to_numpy() == pytest.approx(1.0, rel=0.15)
    assert (slight["ratio_low"] < slight["ratio"]).all()
    # the smaller capacity of the curve lowers the median by as much as the line is steep
    change = Change(name="capacity", capacity="capacity_of_curve")
    lower = medians(curves, scattered_demands(), 3, change).set_index(["component", "state"])
    key = "unseating", "slight"
    assert lower.loc[key, "theta"] / table.loc[key, "theta"] == pytest.approx(1 / 1.5, rel=0.1)


def test_a_state_that_no_run_reaches_has_a_lower_bound_of_its_median():
    curves, demands = PUBLISHED[PUBLISHED["era"] == 3], scattered_demands()
    columns = [f"{WHOLE}{name}" for name in DEMANDS.values()]
    found = medians(curves, demands.assign(**(demands[columns] * 1e-3)), 3, NONE)
    found = found[found["component"] != SYSTEM]
    assert found["theta"].isna().all()
    # 40 runs up to 2.5 g, assumed dispersion 0.4
    assert found["theta_bound"].between(1.0, 2.5).all()
    assert medians(curves, demands, 3, NONE)["theta_bound"].isna().any()


def test_a_change_explains_a_ratio_if_it_closes_half_of_its_distance_from_the_range():
    assert outside(1.0) == outside(1.33) == 0.0
    assert outside(0.75 / 2.0) == pytest.approx(np.log(2.0))
    rows = [
        ("bearing", "none", 1.1), ("bearing", "gap", 1.0),
        ("unseating", "none", 1.33 * 2.0), ("unseating", "gap", 1.33 * 1.3),
        ("unseating", "bridge", 1.33 * 1.8), ("column_curvature", "none", 1.33 * 2.0),
        ("column_curvature", "gap", 1.33 * 1.6), ("column_curvature", "bridge", np.nan),
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=["component", "change", "ratio"])
    found = explanations(table.assign(era=3, state="slight")).set_index("component")
    assert found[["change", "is_explained"]].T.to_dict("list") == {
        "bearing": ["none", True],
        "unseating": ["gap", True],
        "column_curvature": ["gap", False],
    }


# --- effects of skew: paired ratios of demands and factors on medians


def test_factor_of_hazus_at_known_skews():
    """Hazus tables round 0.983, 0.931, 0.841 and 0.707 for 15, 30, 45 and 60 degrees."""
    factors = [hazus_factor(skew) for skew in (0, 15, 30, 45, -60)]
    assert factors == pytest.approx([1.0, 0.983, 0.931, 0.841, 0.707], abs=5e-4)


def test_effects_of_skew_are_those_of_demands_that_grow_by_a_fifth():
    """24 motions, of which one has not the demand of one column."""
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
    table = pd.concat(parts, ignore_index=True)
    factors = median_factors(table).set_index("demand")
    assert factors.loc["column_curvature/moderate", "ratio"] == pytest.approx(1 / 1.2, rel=0.03)
    lacks = (table["motion_id"] == "m00") & (table["skew_deg"] == 60)
    table.loc[lacks, f"{WHOLE}abutment_passive_m"] = 0.0
    found = demand_ratios(table)
    assert set(found["demand"]) == set(COMPARED)
    assert (found["skew_deg"] == 60).all()
    assert found["ratio"].to_numpy() == pytest.approx(1.2, rel=0.03)
    assert (found["ratio_low"] < 1.2 * 1.03).all()
    assert (found["ratio_high"] > 1.2 * 0.97).all()
    count = found.set_index("demand")["n_motions"]
    assert (count["abutment_passive_m"], count["unseating_m"]) == (23, 24)

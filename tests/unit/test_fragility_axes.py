"""A further axis of a study goes through all tables by being a column; the seed reaches them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from fragility_tables import IM, synthetic_demands
from skewbridge.demands.columns import DEMAND_COLUMNS, demands_for
from skewbridge.fragility.exports import export_curves
from skewbridge.fragility.results import read_foreign
from skewbridge.fragility.old_joint.table import joint_table
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.limit_states import demand_unit, load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.system_curves import system_curves
from skewbridge.variant import axes

NEW = "transverse_gap_mm"
STATES = [
    state
    for state in load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
    if state.component in {"column_drift", "deck_displacement"}
]
SETTINGS = FitSettings(bootstrap=199)


@pytest.fixture
def demands(monkeypatch):
    """Two variants of skew, two of a new axis; the demand falls by a tenth along the new one."""
    if not axes.axes_of([NEW]):
        gap = next(axis for axis in axes.AXES if axis.name == "gap_mm")
        new = replace(gap, name=NEW, code="tg", title="the transverse gap")
        monkeypatch.setattr(axes, "AXES", (*axes.AXES, new))
    narrow = synthetic_demands(skews=(0, 30), gaps=(51,), frictions=(50,), motions=20)
    wide = narrow.copy()
    wide["variant"] += "_tg025"
    noise = np.exp(0.01 * np.random.default_rng(3).normal(size=len(wide)))
    for column in demands_for("effect", wide.columns):
        wide[column] *= 0.9 * noise
    return pd.concat([narrow.assign(**{NEW: 6.0}), wide.assign(**{NEW: 25.0})], ignore_index=True)


def test_curves_systems_and_exports_carry_the_new_axis(demands, tmp_path):
    curves = fit_study(demands, STATES, IM, SETTINGS)
    assert set(curves[NEW]) == {6.0, 25.0}
    assert set(system_curves(demands, STATES, IM)[NEW]) == {6.0, 25.0}
    source, out = tmp_path / "curves.parquet", tmp_path / "curves.csv"
    curves.to_parquet(source)
    export_curves(source, "csv", out)
    assert set(pd.read_csv(out)[NEW]) == {6.0, 25.0}


def test_the_new_axis_has_effects_on_demands_and_medians(demands):
    effects = paired_effects(demands, settings=SETTINGS)
    found = effects[(effects["axis"] == NEW) & (effects["scope"] == "pooled")]
    assert set(found["demand"]) == set(demands_for("effect", demands.columns))
    assert found["ratio"].to_numpy() == pytest.approx(0.9, abs=0.02)
    along_skew = effects[(effects["axis"] == "skew_deg") & (effects["scope"] == "variant")]
    assert set(along_skew[NEW]) == {6.0, 25.0}  # pairs share the value of the other axes
    medians = paired_capacity_effects(demands, STATES, IM, SETTINGS)
    assert set(medians["axis"]) == {"skew_deg", NEW}


def test_the_new_axis_is_a_factor_and_a_variable_of_the_joint_model(demands):
    table = factor_summary(demands, ["column_drift_ratio"], SETTINGS).set_index("factor")
    assert list(table.index) == ["skew_deg", NEW]
    assert table.loc[NEW, "p_value"] < 1e-6
    assert table.loc[NEW, "first_order"] > 0.9
    curves = fit_study(demands, STATES, IM, SETTINGS)
    joint = joint_table(demands, STATES, IM, curves, SETTINGS)
    best = joint[joint["preferred"]]
    assert len(best) >= 3
    assert best["terms"].str.contains(NEW).all()


def test_a_foreign_table_brings_the_axes_it_has(demands, tmp_path):
    path = tmp_path / "theirs.csv"
    demands.drop(columns=["gap_mm", "friction"]).to_csv(path, index=False)
    columns = {name: name for name in (NEW, "motion_id", IM, "deck_disp_m", "skew_deg")}
    ours = read_foreign(path, columns)
    assert ours["variant"].nunique() == 4
    assert set(paired_effects(ours, settings=SETTINGS)["axis"]) == {"skew_deg", NEW}


def test_another_seed_draws_another_sobol_sequence():
    demands = synthetic_demands(motions=8)
    first, second, again = (
        factor_summary(demands, ["deck_rotation_rad"], FitSettings(seed=seed)) for seed in (1, 2, 1)
    )
    assert not np.array_equal(first["first_order"], second["first_order"])
    pd.testing.assert_frame_equal(first, again)


def test_the_unit_of_every_demand_is_that_of_its_column():
    names = {"-": "ratio", "m/s2": "mps2"}
    limited = [c for c in DEMAND_COLUMNS if "effect" in c.roles]
    assert [demand_unit(c.name) for c in limited] == [
        names.get(c.unit, c.unit.lower()) for c in limited
    ]
    assert demand_unit("strain_percent") == "percent"

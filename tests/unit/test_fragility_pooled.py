"""Pooled effects, cells drawn towards them, several models in one table, motions still needed."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from fragility_tables import IM, several_models, synthetic_demands
from skewbridge.cli import build_app
from skewbridge.fragility.methods.motion_means import MotionMeans
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.curves import fit_study
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import factor_summary
from skewbridge.fragility.tables.limit_states import load_limit_states
from skewbridge.fragility.tables.median_effects import paired_capacity_effects
from skewbridge.fragility.tables.needed_motions import motions_to_decide, needed_motions
from skewbridge.fragility.tables.system_curves import system_curves
from skewbridge.provenance.tables import write_frame

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
MODEL = ["bridge", "abutment"]


def friction(effects, demand, scope="pooled"):
    return effects[
        (effects["demand"] == demand)
        & (effects["axis"] == "friction")
        & (effects["scope"] == scope)
    ]


def test_pooled_rows_come_first_and_are_the_average_of_their_cells():
    effects = paired_effects(synthetic_demands(), ["deck_disp_m", "unseating_m"])
    scopes = effects["scope"].tolist()
    assert scopes == sorted(scopes)
    pooled = friction(effects, "deck_disp_m").iloc[0]
    cells = friction(effects, "deck_disp_m", "variant")
    assert pooled["n_cells"] == len(cells) == 6
    assert np.log(pooled["ratio"]) == pytest.approx(np.log(cells["ratio"]).mean())
    assert pooled["ci_high"] - pooled["ci_low"] < (cells["ci_high"] - cells["ci_low"]).min()


def test_an_effect_that_varies_between_cells_is_seen_and_hardly_shrunk():
    table = synthetic_demands(friction_effect=0.0)
    alike = paired_effects(table, ["deck_disp_m"])
    grown = (table["friction"] == 0.5) & (table["skew_deg"] == 45)
    table.loc[grown, "deck_disp_m"] *= 1.3
    varied = paired_effects(table, ["deck_disp_m"])
    assert friction(alike, "deck_disp_m")["p_cells"].iloc[0] > 0.01
    assert friction(varied, "deck_disp_m")["p_cells"].iloc[0] < 1e-6
    spread = {}
    for name, effects in (("alike", alike), ("varied", varied)):
        cells = np.log(friction(effects, "deck_disp_m", "variant")[["ratio", "shrunk_ratio"]])
        spread[name] = cells["shrunk_ratio"].std() / cells["ratio"].std()
    assert spread["alike"] < 0.7
    assert spread["varied"] == pytest.approx(1.0, abs=0.02)


def test_the_correction_of_the_f_test_is_none_for_like_scatter_and_full_for_one_contrast():
    rng = np.random.default_rng(1)
    alike = MotionMeans.of(rng.normal(size=(400, 4))).difference()
    assert alike.dof == pytest.approx(3.0, abs=0.05)
    # one motion-dependent shift of one cell is all that scatters: a single degree of freedom
    single = np.outer(rng.normal(size=400), [1.0, 0.0, 0.0, 0.0]) + 1e-6 * rng.normal(size=(400, 4))
    assert MotionMeans.of(single).difference().dof == pytest.approx(1.0, abs=0.05)


def test_two_bridges_and_five_abutment_models_go_through_all_statistics():
    table = several_models(motions=8)
    effects = paired_effects(table)
    axes = effects.groupby(MODEL)["axis"].unique().map(set)
    assert len(axes) == 10
    for (_, abutment), found in axes.items():
        wanted = {"skew_deg"} | ({"gap_mm"} if abutment != "roller" else set())
        assert found == wanted | ({"friction"} if abutment == "contact_friction" else set())
    one = table[(table["bridge"] == "osb2s") & (table["abutment"] == "spring")]
    own = effects[(effects["bridge"] == "osb2s") & (effects["abutment"] == "spring")]
    alone = paired_effects(one)
    pd.testing.assert_frame_equal(alone, own.reset_index(drop=True), check_dtype=False)
    factors = factor_summary(table, ["deck_disp_m", "unseating_m"])
    for (*model, _), own in factors.groupby([*MODEL, "demand"]):
        assert set(own["factor"]) == axes[tuple(model)]
    assert factors["p_value"].notna().all()
    options = FitSettings(bootstrap=99)
    states = [state for state in STATES if state.component in {"column_drift", "unseating"}]
    curves = fit_study(table, states, IM, options)
    assert set(curves["variant"]) == set(table["variant"])
    assert len(system_curves(table, states, IM, options))
    medians = paired_capacity_effects(table, states[:1], IM, options)
    assert len(medians.groupby(MODEL)) > 5
    needed = needed_motions(effects, table)
    assert set(map(tuple, needed[MODEL].to_numpy())) == set(axes.index)


def test_the_motions_that_decide_follow_from_scatter_and_distance():
    row = {"judged_by": "ratio", "margin": 0.05, "level": 0.9, "scatter": 0.06}
    # ln 1.05 = 0.0488; (1.645 + 0.842)^2 0.06^2 / 0.0188^2 = 63 with normal quantiles
    found = motions_to_decide(row | {"ratio": np.exp(0.03)})
    assert found == pytest.approx(64, abs=2)
    assert motions_to_decide(row | {"ratio": 1.0}) < 15
    assert motions_to_decide(row | {"ratio": 1.0501}) == np.inf
    assert np.isnan(motions_to_decide(row | {"ratio": np.nan}))
    turned = {"judged_by": "difference", "difference": 0.2, "difference_margin": 0.1}
    assert motions_to_decide(row | turned | {"scatter": 0.1}) < 15


def test_the_motions_that_are_missing_cost_their_analyses():
    few = synthetic_demands(motions=12, run_scatter=0.12, seed=8)
    few.loc[few["friction"] == 0.5, "unseating_m"] *= 1.03
    few["cpu_s"] = 36.0
    effects = paired_effects(few, ["unseating_m"])
    found = needed_motions(effects, few).set_index("axis").loc["friction"]
    assert (found["forecast"], found["n_motions"]) == ("more motions", 12)
    more = found["needed_motions"] - 12
    assert found["more_analyses"] == more * 12
    assert found["more_core_hours"] == pytest.approx(more * 12 / 100)


def test_plan_says_how_many_motions_would_decide(tmp_path):
    table = synthetic_demands(motions=12, run_scatter=0.1).assign(cpu_s=4.0)
    needed = needed_motions(paired_effects(table), table)
    results = tmp_path / "results"
    write_frame(needed, results / "fragility" / "needed_motions.parquet", {})
    config = tmp_path / "config.yaml"
    config.write_text(f"results: {results}\n")
    run = CliRunner().invoke(build_app(), ["plan", "--config", str(config), "--json"])
    assert run.exit_code == 0
    said = json.loads(run.stdout)["needed_motions"]
    assert len(said) == len(needed) > 0
    assert set(said[0]) == set(needed.columns)
    shown = CliRunner().invoke(build_app(), ["plan", "--config", str(config)])
    assert "Motions that decide the pooled effects" in shown.stdout

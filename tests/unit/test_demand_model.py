"""Demand model of a bridge: known parameters, incomplete blocks, events, one value each."""

from itertools import combinations, product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from median_coverage import CASES, covered
from scipy import special

from fragility_tables import IM, SETTINGS, models_of, ready, states_of, synthetic_demands
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_model import StateCurve, fit_models
from skewbridge.fragility.effects import effect_tables, median_effects
from skewbridge.fragility.fits import FragilityFit, jackknifed
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.motion_means import Jackknifed
from skewbridge.fragility.study_tables import fragility_tables

DRIFT = states_of("column_drift")[:2]
AXES = ["skew_deg", "gap_mm", "friction"]


def study(motions=24, **options):
    """Return demands in which skew 30 and 60 degrees change the drift by 0.05 and 0.15."""
    table = synthetic_demands(motions=motions, skews=(0, 30, 60), **options)
    shift = table["skew_deg"].map({0: 0.0, 30: 0.05, 60: 0.15})
    return table.assign(column_drift_ratio=table["column_drift_ratio"] * np.exp(shift))


def numbers(table):
    return table["motion_id"].str[1:].astype(int).to_numpy()


def in_two_cells(table):
    """Return the runs in two of the four cells of gap and friction, other cells by motion."""
    cells = list(combinations(product((25, 51), (0.0, 0.5)), 2))
    runs = zip(table["gap_mm"], table["friction"], numbers(table) % 6, strict=True)
    return np.array([(gap, friction) in cells[m] for gap, friction, m in runs])


def effects_of(table, scope="pooled"):
    found = median_effects(models_of(table, DRIFT), DRIFT, SETTINGS)
    found = found[(found["scope"] == scope) & (found["demand"] == "column_drift/slight")]
    return found.set_index(["axis", "to_value"])


def skew_60(table):
    return effects_of(table).loc[("skew_deg", 60)]


def test_a_bend_and_growing_scatter_are_found_with_their_parameters():
    rng, table = np.random.default_rng(3), study(160)
    x = np.log(table[IM]) - np.log(table[IM]).mean()
    own, run = 0.25 * rng.normal(size=160), 0.05 * rng.normal(size=len(x))
    scatter = np.exp(0.4 * x) * (own[numbers(table)] + run)
    table["column_drift_ratio"] = np.exp(-4.0 + 1.2 * x - 0.7 * np.maximum(x, 0.0) + scatter)
    (models,) = models_of(table, DRIFT)
    model = models.fit(DRIFT[0]).model
    level, slope, bend, *_, growth, ln_tau, ln_sigma = model.parameters[0]
    assert model.knot == pytest.approx(0.0, abs=0.1)
    assert (level, slope, bend) == pytest.approx((-4.0, 1.2, -0.7), abs=0.15)
    assert growth == pytest.approx(0.4, abs=0.1)
    assert np.exp([ln_tau, ln_sigma]) == pytest.approx([0.25, 0.05], rel=0.2)
    # the median is where the model reaches the threshold
    variant = models.variants.iloc[0]
    ln_theta = models.curve(DRIFT[0], variant).ln_theta[:1, None]
    z = model.at(variant).score(DRIFT[0].threshold, DRIFT[0].dispersion, ln_theta)[0, 0]
    assert z == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "other", "statuses"),
    [(1.2, 1.0, ["ok", "no_curve"]), (1.4, 1.0, ["no_curve"] * 2), (1.2, 1.1, ["ok"] * 2)],
)
def test_unknown_outcomes_may_change_a_ratio_with_one_median_by_15_percent(change, other, statuses):
    models = models_of(synthetic_demands(skews=(0, 30), gaps=(25, 51), frictions=(50,)), DRIFT)
    curves = fit_study(models, DRIFT, SETTINGS)
    at = (curves["gap_mm"] == 51) & (curves["limit_state"] == "slight")
    ends = curves["skew_deg"].map({0: other, 30: change}).where(at, 1.0)
    curves = curves.assign(theta_none_exceed=ends, theta_all_exceed=1.0)
    curves["preferred"] &= ~(at & (curves["skew_deg"] == 30))
    found = median_effects(models, DRIFT[:1], SETTINGS, curves=curves)
    found = found[found["axis"] == "skew_deg"].query("scope != 'by_value'")
    assert found["status"].iloc[[0, 2]].tolist() == statuses
    assert found["n_without_curve"].tolist() == [1, 0, 1]


def test_incomplete_blocks_give_the_effects_of_the_complete_study():
    table = study(24)
    part = table[in_two_cells(table)]
    whole, half = effects_of(table), effects_of(part)
    assert (len(part), set(half.index)) == (len(table) / 2, set(whole.index))
    assert np.log(half["ratio"] / whole["ratio"]).abs().max() < 0.02
    assert np.log(half["ci_high"] / half["ci_low"]).max() < 0.08
    mixed = effects_of(part.sample(frac=1.0, random_state=2))
    assert mixed["ratio"].to_numpy() == pytest.approx(half["ratio"].to_numpy(), rel=1e-6)


def test_orientations_of_a_motion_do_not_enter_the_effects_of_gap_and_friction():
    """The second orientation has other demands and the other two cells of each motion."""
    table = study(24)
    first = in_two_cells(table)
    turned = np.exp(0.4 * np.random.default_rng(1).normal(size=24))[numbers(table)]
    both = table.assign(
        incidence_deg=np.where(first, 0.0, 90.0),
        column_drift_ratio=table["column_drift_ratio"] * np.where(first, 1.0, turned),
    )
    plain, found = effects_of(table), effects_of(both)
    assert np.log(found["ratio"] / plain["ratio"]).abs().max() < 0.02
    assert np.log(found["ci_high"] / found["ci_low"]).max() < 0.08  # the scatter is 0.4


def test_motions_of_one_event_are_one_block_and_two_events_choose_no_shape():
    """Every motion twice: without the event, intervals would be narrower by the root of two."""
    table = study(16, run_scatter=0.1)
    twice = pd.concat([table, table.assign(motion_id=table["motion_id"] + "b")], ignore_index=True)
    event = twice.assign(event=twice["motion_id"].str[:3])
    alone, apart, together = found = [skew_60(rows) for rows in (table, twice, event)]
    unnamed = skew_60(twice.assign(event=""))  # as in a table of synthetic motions
    same = ["ratio", "ci_low", "ci_high", "n_effective_motions", "largest_motion"]
    assert unnamed[same].tolist() == apart[same].tolist()
    drift = [effect_tables(rows, ["column_drift_ratio"], SETTINGS).effects.iloc[0]
             for rows in (table, twice, event)]  # fmt: skip
    for rows, rel in ((drift, 1e-6), (found, 0.1)):
        one, two, block = (
            np.log(row["ci_high"] / row["ci_low"])
            / special.stdtrit(row["dof"], 0.5 + 0.5 * row["level"])  # standard errors
            for row in rows
        )
        assert block == pytest.approx(one, rel=rel)
        assert two == pytest.approx(one / np.sqrt(2.0), rel=0.1)
    assert apart["ratio"] == pytest.approx(together["ratio"], rel=1e-3)
    assert together["n_effective_motions"] == pytest.approx(alone["n_effective_motions"], rel=0.2)
    table = study()
    for count in (1, 2):
        rows = ready(table.assign(event=[f"e{n % count}" for n in numbers(table)]), DRIFT)
        parameters = fit_models(rows, DRIFT, SETTINGS)[0].fit(DRIFT[0]).model.parameters
        assert np.abs(parameters[0, [2, -3]]).max() < 1e-9  # neither bend nor growth
        assert np.ptp(parameters[: 1 + count], axis=0).any() == (count > 1)


def test_a_motion_with_most_of_the_variance_is_named():
    table = study(24)
    odd = (table["motion_id"] == "m07") & (table["skew_deg"] == 60)
    table["column_drift_ratio"] *= np.where(odd, 1.8, 1.0)
    row = skew_60(table)
    assert (row["largest_motion"], row["largest_share"] > 0.5) == ("m07", True)
    assert row["n_effective_motions"] < 3.0
    # the error from the prior of the drift, which is not a motion's, adds degrees of freedom
    assert 3.0 <= row["dof"] / row["n_effective_motions"] < 3.5


def test_an_effect_that_depends_on_another_axis_is_given_by_its_value():
    table = study(24)
    assert (effects_of(table)["p_interaction"] > 0.05).all()
    more = (table["gap_mm"] == 25) & (table["skew_deg"] == 60)
    table["column_drift_ratio"] *= np.where(more, np.exp(0.1), 1.0)
    row = skew_60(table)
    assert (row["interaction"], row["p_interaction"] < 0.001) == ("gap_mm", True)
    by_gap = effects_of(table, "by_value").loc[[("skew_deg", 60)]].dropna(subset="gap_mm")
    by_gap = np.log(by_gap.set_index("gap_mm")["ratio"])
    assert by_gap[25] - by_gap[51] == pytest.approx(-0.1, abs=0.02)
    assert by_gap.mean() == pytest.approx(np.log(row["ratio"]), abs=1e-9)


def test_dependence_on_any_other_axis_is_tested_once_for_each(monkeypatch):
    monkeypatch.setattr(Jackknifed, "p_value", lambda _: 0.02)
    table = study(8).query("skew_deg != 30")
    found = median_effects(models_of(table, DRIFT[:1]), DRIFT[:1], SETTINGS)
    assert found["scope"].drop_duplicates().tolist() == ["pooled", "by_value", "variant"]
    pooled = found.query("scope == 'pooled'")["p_interaction"]
    assert pooled.tolist() == pytest.approx([0.04] * 3)  # two other axes


def test_no_two_tables_give_different_numbers_for_one_quantity():
    table = study(16, run_scatter=0.1)
    states = [*states_of("column_drift")[:2], *states_of("unseating")[:1]]
    tables = fragility_tables(table, states, SETTINGS)
    assert set(tables["curves"].query("preferred")["method"]) == {"cloud"}
    curves = tables["curves"].query("method == 'cloud' and status == 'ok'")
    curves = curves.assign(demand=curves["component"] + "/" + curves["limit_state"])
    theta = curves.set_index(["demand", *AXES])
    rows = tables["joint"].query("status == 'ok'").to_dict("records")
    models = {f"{row['component']}/{row['limit_state']}": JointModel(row) for row in rows}
    names = ["theta", "theta_low", "theta_high"]
    for row in curves.to_dict("records"):
        model = models[row["demand"]]
        assert model.median(row, level=row["level"]) == pytest.approx([row[n] for n in names])
        curve = model.curve(row)
        assert (curve.beta[0], curve.total[0]) == pytest.approx((row["beta"], row["beta_total"]))
    without = np.where(np.arange(curve.beta.size) == 1, np.nan, curve.ln_theta)  # only beta is left
    fit = FragilityFit(method="cloud", status="ok", n_runs=48, level=0.9)
    ends = jackknifed(fit, without, curve.beta, curve.priors).ci_theta
    assert curve._replace(ln_theta=without).ln_median().exp_interval(0.9)[1:] == pytest.approx(ends)
    medians = tables["median_effects"].query("scope == 'variant'").to_dict("records")
    assert len(medians) > 20
    printed = tables["table"].set_index(["component", "limit_state", "row"])
    for row in medians:
        place = {name: row[name] for name in AXES}
        ends = [place | {row["axis"]: row[f"{end}_value"]} for end in ("from", "to")]
        first, other = (theta.loc[(row["demand"], *end.values())] for end in ends)
        assert row["from_mean"] == pytest.approx(first["theta"])
        assert row["ratio"] == pytest.approx(other["theta"] / first["theta"])
        ratio = models[row["demand"]].median(ends[1], ends[0], row["level"])
        assert ratio == pytest.approx((row["ratio"], row["ci_low"], row["ci_high"]))
        shown = printed.loc[(*row["demand"].split("/"), other["variant"])]
        assert shown["theta"] == pytest.approx(other["theta"])
        assert shown[f"{row['axis'].split('_')[0]}_ratio"] == pytest.approx(row["ratio"])
    system = tables["system"].query("status == 'ok' and components == 'unseating'")
    for row in system.to_dict("records"):
        own = theta.loc[(f"unseating/{row['limit_state']}", *(row[name] for name in AXES))]
        assert row["theta"] == pytest.approx(own["theta"], rel=5e-3)


@pytest.mark.parametrize("case", CASES)
def test_a_simulated_study_of_known_effects_has_intervals(case):
    found = covered(np.random.default_rng(2), case)
    widths = [value for name, value in found.items() if name.endswith("width")]
    assert (len(widths), max(widths) < 0.12) == (4, True)


def test_a_demand_that_falls_without_some_motion_gives_no_numerical_warning():
    point = SimpleNamespace(slope_at=lambda _: np.array([1.0, 0.9, -0.2, 1.2, 1.1]))
    medians = np.array([1.0, 1.1, np.nan, 0.9, 1.0])
    first, second = (StateCurve(c * medians, *np.ones((2, 5)), points=((point, None),))
                     for c in (0.1, 0.3))  # fmt: skip
    assert second.ln_ratio(first).estimate == pytest.approx(0.2)

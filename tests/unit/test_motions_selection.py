"""Conditional spectra against closed forms, files with targets, and selections of pairs."""

import json
import re
from importlib import import_module

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from cli_json import invoke
from motions_files import index_of, make_pairs
from skewbridge.errors import InputError
from skewbridge.motions import selection
from skewbridge.motions.folder import list_motions
from skewbridge.motions.intensity import sa_avg_periods
from skewbridge.motions.suite import prepare_suite, read_entries
from skewbridge.motions.synthesis import Scenario, baker_jayaram_correlation, bssa14
from skewbridge.study import jobs
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import check_inputs

NEAR = {"magnitude": 6.5, "distance_km": 10.0, "epsilon": 1.0}
SCENARIO = Scenario(magnitude=6.5, distance_km=10.0, vs30_mps=400.0)
SITE = {"vs30_mps": 400.0}
USGS = """{"status": "success", "response": [{"metadata": {"imt": {"value": "SA0P75"},
"εbins": [{"id": 1, "min": 1, "max": 1.5}, {"id": 2, "min": 1.5}]}, "data": [{"component": "Total",
"data": [{"r": 12, "m": 6.9, "εdata": [{"εbin": 1, "value": 30}, {"εbin": 2, "value": 10}]}],
"summary": [{"data": [{"value": 975, "units": "yrs"}, {"value": 0.8, "units": "g"}]}]}]}]}"""
HAND = "measure: SA(0.75)\nvs30_mps: 400\nlevels: [{magnitude: 6.5, distance_km: 10, epsilon: 1}]"


def _spectra(*levels, measure="SA(0.75)", **more):
    target = selection.Target(measure=measure, **SITE, levels=levels, **more)
    return selection.conditional_spectra(target)


def test_condition_has_the_values_computed_by_hand():
    """Correlation 0.5: one variable known, then the mean of both (variance 0.75)."""
    given = np.zeros((1, 2)), np.ones((1, 2)), np.array([[1.0, 0.5], [0.5, 1.0]])
    for weights, value, means, sigmas in (
        ([1.0, 0.0], 2.0, [2.0, 1.0], [0.0, np.sqrt(0.75)]),
        ([0.5, 0.5], 1.0, [np.sqrt(0.75)] * 2, [0.5, 0.5]),
    ):
        found = selection.condition(*given, np.array(weights), np.array([value]))
        np.testing.assert_allclose(found, [[means], [sigmas]])


def test_spectrum_of_one_period_agrees_with_pygmm():
    pygmm = pytest.importorskip("pygmm")
    (found,) = _spectra(NEAR)
    place = pygmm.Scenario(mag=6.5, dist_jb=10.0, v_s30=400.0, mechanism="SS", region="global")
    model = pygmm.BooreStewartSeyhanAtkinson2014(place)
    psa_g, sigma = (f(found.periods_s) for f in (model.interp_spec_accels, model.interp_ln_stds))
    level = np.log(psa_g[-1]) + sigma[-1]
    conditioned = import_module("pygmm.baker_jayaram_2008").calc_cond_mean_spectrum
    mean, deviation = conditioned(found.periods_s, np.log(psa_g), sigma, 0.75, level)
    # pygmm has coefficients at more periods
    np.testing.assert_allclose(found.median_g, np.exp(mean), rtol=0.01)
    np.testing.assert_allclose(found.sigma[:-1], deviation[:-1], rtol=0.02)
    assert found.sigma[-1] == pytest.approx(0.0, abs=1e-7)
    assert found.causes["level_g"] == pytest.approx(found.median_g[-1])


def test_spectrum_of_sa_avg_has_the_published_correlation():
    """Kohrangi et al. (2017): sums over 20 periods give the deviation of ln Sa_avg and rho."""
    found, middle = _spectra(*[NEAR, NEAR | {"epsilon": 0.0}], measure="Sa_avg(1.0)", t1_s=2.5)
    periods = np.append(0.5, sa_avg_periods(1.0))
    tabulated = [0.2, 0.25, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0]
    sigma = np.interp(np.log(periods), np.log(tabulated), bssa14(SCENARIO, tabulated)[1])
    terms = baker_jayaram_correlation(periods) * np.outer(sigma, sigma)
    sigma_avg = np.sqrt(terms[1:, 1:].sum()) / 20.0
    rho = terms[0, 1:].sum() / (20.0 * sigma[0] * sigma_avg)
    # deviations between tabulated periods are interpolated in another way
    assert found.sigma[0] == pytest.approx(sigma[0] * np.sqrt(1.0 - rho**2), rel=5e-3)
    rise = np.log([found.median_g[0], found.causes["level_g"]])
    rise -= np.log([middle.median_g[0], middle.causes["level_g"]])
    assert rise == pytest.approx([rho * sigma[0], sigma_avg], rel=5e-3)


def test_earthquakes_of_a_level_are_mixed_and_scaled_to_it():
    far = {"magnitude": 8.0, "distance_km": 90, "epsilon": 2.5, "weight": 3}
    two = [NEAR | {"level_g": 0.6}, far | {"level_g": 0.6}]
    (mixed,), (one,), (other,) = _spectra(*two), _spectra(two[0]), _spectra(two[1])
    logs = np.log([one.median_g, other.median_g])
    np.testing.assert_allclose(np.log(mixed.median_g), [0.25, 0.75] @ logs)
    within = 0.25 * one.sigma**2 + 0.75 * other.sigma**2
    between = 0.25 * 0.75 * (logs[0] - logs[1]) ** 2
    np.testing.assert_allclose(mixed.sigma**2, within + between, atol=1e-12)
    assert mixed.median_g[-1] == pytest.approx(0.6)
    assert mixed.causes["magnitude"] == pytest.approx(0.25 * 6.5 + 0.75 * 8.0)


def _openquake(path, cells, *, star=False):
    """Write an export of OpenQuake with bins of 0.25 for (magnitude, distance, epsilon, rate)."""
    rows, edges = [], np.arange(-3.0, 4.01, 0.25)
    for magnitude, distance_km, epsilon, rate in cells:
        above = -np.diff(norm.sf(np.maximum(edges, epsilon))) / norm.sf(epsilon)
        values = -np.expm1(-rate * (np.histogram(epsilon, edges)[0] if star else above))
        cell = ("SA(0.75)", 0.5, magnitude, distance_km)
        rows += [(*cell, *own) for own in zip(edges[:-1] + 0.125, values, strict=True)]
    table = pd.DataFrame(rows, columns=["imt", "iml", "mag", "dist", "eps", "mean"])
    path.write_text("#,,generated_by='OpenQuake engine 3.19.0'\n" + table.to_csv(index=False))
    return path


@pytest.mark.parametrize("star", [False, True])
def test_openquake_export_gives_the_epsilon_of_the_level(tmp_path, star):
    cells = [(6.5, 10.0, 0.6, 2e-3), (7.5, 40.0, 1.9, 1e-3)]
    causes = selection.read_target(_openquake(tmp_path / "a.csv", cells, star=star), SITE).levels
    found = np.array([(c.magnitude, c.level_g, c.epsilon, c.weight) for c in causes])
    np.testing.assert_allclose(found[:, 2], [0.6, 1.9], atol=0.125)  # half a bin
    np.testing.assert_allclose(found[:, 3], [2e-3, 1e-3], rtol=2e-3)  # the bins end at 4
    assert found[:, :2].tolist() == [[6.5, 0.5], [7.5, 0.5]]


@pytest.mark.parametrize("is_new", [False, True])
def test_usgs_response_gives_epsilon_and_level(tmp_path, is_new):
    content = json.loads(USGS)
    if is_new:
        about = content["response"][0].pop("metadata")
        content["response"][0]["imt"] = about.pop("imt")
        content["response"] = {"metadata": about, "disaggs": content["response"]}
    (tmp_path / "a.json").write_text(json.dumps(content))
    target = selection.read_target(tmp_path / "a.json", SITE)
    assert target.measure == "SA(0.75)"
    found = [(c.magnitude, c.distance_km, c.epsilon, c.weight, c.level_g) for c in target.levels]
    assert found == [(6.9, 12.0, 1.25, 30.0, 0.8), (6.9, 12.0, 1.5, 10.0, 0.8)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (", epsilon: 1", "", r"levels.0.epsilon: is missing"),
        ("SA(0.75)", "PGV", r"measure: .*SA.*got 'PGV'"),
        ("SA(0.75)", "SA(5)", r"within 0.01 to 10 s, got 1 to 15 s"),
        ("magnitude: 6.5", "magnitude: 65", "magnitude must be within 3.0 to 8.5, got 65"),
        ("vs30_mps: 400\n", "", "vs30_mps: is missing"),
        ("epsilon: 1", "epsilon: 1, weight: 2", r"levels.0: weight needs level_g"),
    ],
)
def test_wrong_target_is_one_error_before_candidates_are_read(tmp_path, old, new, message):
    (tmp_path / "a.yaml").write_text(HAND.replace(old, new))
    places = ("--from", "no_folder", "--out", tmp_path / "out")
    result = invoke("motions", "select", "--target", tmp_path / "a.yaml", *places)
    assert (result.exit_code, result.stderr.count("error:")) == (2, 1)
    assert re.search(f"a.yaml: .*{message}", result.stderr)
    assert "at least 1 item" not in result.stderr  # a list with a wrong item is not empty
    assert not (tmp_path / "out").exists()


def test_disaggregation_without_epsilon_or_measure_is_an_error(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(USGS.replace("εbins", "bins"))
    with pytest.raises(InputError, match=r"by magnitude, distance and epsilon: 'εbins'"):
        selection.read_target(path, SITE)
    path.write_text(USGS.replace('"data": [{"r"', '"data": 1, "x": [{"r"'))
    with pytest.raises(InputError, match="is not a disaggregation of the USGS"):
        selection.read_target(path, SITE)
    path = _openquake(tmp_path / "a.csv", [(6.5, 10, 1, 1e-3)])
    with pytest.raises(InputError, match=r"has SA\(0.75\): select with --set measure=NAME"):
        selection.read_target(path, SITE | {"measure": "SA(1.0)"})
    path.write_text(path.read_text().replace("dist,eps", "dist,lon"))
    with pytest.raises(InputError, match=r"a.csv is not the export Mag_Dist_Eps .*eps"):
        selection.read_target(path, SITE)


@pytest.mark.parametrize(
    ("measure", "t1_s"), [("SA(0.75)", 0.75), ("SA(0.75)", 0.25), ("Sa_avg(0.75)", 0.75)]
)
def test_two_disjoint_selections_meet_the_tolerances(measure, t1_s):
    """Candidates have the spectra of the target before scaling: three of each event, then as many
    synthetic ones. With T1 0.25 s, the period of SA is that of the last error."""
    (target,), rng = _spectra(NEAR, measure=measure, t1_s=t1_s), np.random.default_rng(1)
    every = baker_jayaram_correlation(target.periods_s)
    mean, gain = np.log(target.median_g), every @ target.weights
    covariance = every - np.outer(gain, gain) / (gain @ target.weights)
    factor = target.sigma / np.sqrt(np.maximum(covariance.diagonal(), 1e-12))
    logs = rng.multivariate_normal(0.0 * mean, covariance, 300, method="eigh")
    logs = logs * factor + mean + rng.uniform(-1.6, 1.6, (300, 1))
    made = np.arange(300) >= 150
    events = [n if made[n] else -n // 3 for n in range(300)]
    pool = pd.DataFrame({"log_psa": list(logs), "event": events, "is_synthetic": made})
    first, summary = selection.select_pairs(pool, target, 30)
    second = selection.select_pairs(pool.drop(first.index), target, 30)
    assert summary["synthetic_share"] == first["is_synthetic"].mean() < 0.5
    for chosen, found in ((first, summary), second):
        assert (len(chosen), chosen["event"].value_counts().max() <= 2) == (30, True)
        assert chosen["scale"].between(0.25, 4.0).all()
        band = slice(selection.BAND_POINTS - (t1_s < 0.75))
        logs = np.stack(chosen["log_psa"])[:, band]
        ratio = np.exp(logs.mean(axis=0)) / target.median_g[band]
        scatter = logs.std(axis=0, ddof=1) / target.sigma[band]
        assert np.abs(ratio - 1.0).max() == pytest.approx(found["mean_error"])
        assert found["mean_error"] < 0.05
        assert np.abs(scatter - 1.0).max() < 0.10
    with pytest.raises(InputError, match=r"only 2 pairs reach .* 2 per event: 3 are needed"):
        selection.select_pairs(pool[1:4], target, 3)


@pytest.fixture
def site(tmp_path):
    """Return a function that makes a study of some levels of a target, and the median Sa."""
    (mine := tmp_path / "mine").mkdir()
    index_of(mine, make_pairs(mine, 12), event=[f"event {n // 2}" for n in range(12)])
    psa_g = prepare_suite(mine, t1_s=0.75)["im_sa_t1_rotd50_g"].median()

    def study(*factors, more=(), **keys):
        levels = [NEAR | {"level_g": float(factor * psa_g)} for factor in factors]
        target = {"measure": "SA(0.75)", **SITE, "levels": levels}
        (tmp_path / "a.yaml").write_text(json.dumps(target))
        chosen = {"target": str(tmp_path / "a.yaml"), "candidates": [str(mine)], "count": 4, **keys}
        motions = {"selection": chosen, **dict(more)}
        return parse_config({"results": str(tmp_path / "results"), "motions": motions})

    return study, psa_g


def _select(folder, count, name, *options):
    given = ("--target", folder / "a.yaml", "--from", folder / "mine", "--out", folder / name)
    return invoke("motions", "select", *given, "--count", count, *options)


def test_components_of_one_file_name_are_both_copied(tmp_path):
    for name, pair in zip("pq", make_pairs(tmp_path, 2), strict=True):
        for folder, file in zip(("EW", "NS"), pair, strict=True):
            (tmp_path / folder).mkdir(exist_ok=True)
            file.rename(tmp_path / folder / f"{name}.AT2")
    rows = "p,EW/p.AT2,NS/p.AT2\nq,EW/q.AT2,NS/q.AT2\n"
    (tmp_path / "index.csv").write_text(f"motion_id,file_1,file_2\n{rows}")
    candidates = selection.read_candidates([tmp_path], np.array([1.0]), 2)
    selection.write_selections([candidates.assign(scale=1.0, level_g=1.0)], tmp_path / "out")
    copied = read_entries(list_motions(tmp_path / "out"))
    for motion, given in zip(copied, candidates["motion"], strict=True):
        np.testing.assert_array_equal(motion.components, given.components)


def test_selected_folder_is_read_with_its_factors(site, tmp_path):
    study, psa_g = site
    study(0.9, 1.2)
    result = _select(tmp_path, 4, "one")
    assert (result.exit_code, result.stderr.count("times that of BSSA14 at this")) == (0, 2)
    suite, index = (
        prepare_suite(tmp_path / "one", t1_s=0.75),
        pd.read_csv(tmp_path / "one/index.csv"),
    )
    reached_g = suite["scale"] * suite["im_sa_t1_rotd50_g"]
    np.testing.assert_allclose(reached_g, psa_g * np.repeat([0.9, 1.2], 4), rtol=1e-6)
    assert index["motion_id"].tolist() == (index["candidate"] + np.repeat(["_1", "_2"], 4)).tolist()
    assert _select(tmp_path, 4, "two", "--without", tmp_path / "one").exit_code == 0
    assert set(index["candidate"]).isdisjoint(pd.read_csv(tmp_path / "two/index.csv")["candidate"])


def test_a_study_selects_as_the_command_and_after_a_change(site, tmp_path, monkeypatch, caplog):
    study, psa_g = site
    selected = tmp_path / "results/motions/selected"
    config = study(0.9, 1.2)
    check_inputs(config)
    assert caplog.text.count("times that of BSSA14 at this") == 2
    assert (config.motions.folder, config.motions.count) == (str(selected), None)
    index = pd.read_csv(selected / "index.csv")
    assert _select(tmp_path, 4, "by_command").exit_code == 0
    pd.testing.assert_frame_equal(index, pd.read_csv(tmp_path / "by_command/index.csv"))
    made = jobs.made_from(config)
    with monkeypatch.context() as patch:
        patch.delattr(selection, "select_motions")
        assert jobs.made_from(study(0.9, 1.2)) == made
    changed = jobs.made_from(study(0.9, 1.1))  # only the target file
    assert changed["prepare_motions"]["motions"] != made["prepare_motions"]["motions"]
    levels_g = pd.read_csv(selected / "index.csv")["level_g"]
    np.testing.assert_allclose(levels_g, psa_g * np.repeat([0.9, 1.1], 4))


@pytest.mark.parametrize(
    ("keys", "more", "message"),
    [
        ({"target": "nowhere.yaml"}, {}, r"^nowhere\.yaml cannot be read"),
        ({"count": 13}, {}, r"^count must be from 2 to the 12 candidates, got 13$"),
        ({"values": {"vs30_mps": 40}}, {}, r"vs30_mps: must be .* 150, got 40$"),
        ({"without": "nowhere"}, {}, r"^nowhere/index\.csv cannot be read"),
        ({}, {"folder": "mine"}, r"give selection or folder, not both$"),
        ({}, {"bands": {}}, r"selection sets the levels: set bands: null"),
        ({}, {"design": "stripes"}, r"selection sets the levels: set .* scaled_cloud$"),
    ],
)
def test_wrong_selection_of_a_study_is_one_error(site, tmp_path, keys, more, message):
    with pytest.raises(InputError, match=message) as caught:
        check_inputs(site[0](0.9, more=more, **keys))
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "results/motions/selected/index.csv").exists()

"""Suites of motions as a factor, and the shipped suite: what its generator makes."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from cli_json import answer
from fragility_tables import states_of, synthetic_demands
from motions_files import index_of, make_pairs
from skewbridge.bridge.library import load_structure
from skewbridge.errors import InputError
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.study_tables import ALL_SUITES, DEPENDS, NO_DIFFERENCE, fragility_tables
from skewbridge.motions import intensity, record, synthesis
from skewbridge.motions import suite as motion_suite
from skewbridge.motions.folder import list_motions
from skewbridge.motions.levels import FACTOR_LIMITS
from skewbridge.motions.read import read_motion
from skewbridge.report.answer import answer_table, suites_summary
from skewbridge.study import analyses, config, inputs
from skewbridge.study.task import run_key
from skewbridge.units import G_MPS2
from skewbridge.variant.grid import expand_grid

ROOT = Path(__file__).parents[2]
STATES = [state for state in states_of("unseating") if state.name == "slight"]
KEYS = ["variant", "bridge", "abutment", "skew_deg", "gap_mm", "friction", "motion_id", "scale",
        "incidence_deg", "status"]  # fmt: skip
MOTIONS = ROOT / "motions"
SOME = 48  # a block of those that are made, too
MADE = [entry for entry in list_motions(MOTIONS) if not entry.components]
T1_S = load_structure(config.CONDITIONING_BRIDGE).t1_s


def motions_of(**given: object):
    return config.parse_config({"motions": given}).motions


def test_suites_of_a_configuration(in_the_repository: None, tmp_path: Path) -> None:
    (default,) = motion_suite.suite_sources(motions_of())
    assert (default.name, default.folder, default.count) == ("near", Path("motions"), 32)
    shipped = motion_suite.suite_sources(motions_of(suites=["near", "far", "pulse"]))
    assert {each.name: each.count for each in shipped} == {"near": 32, "far": 16, "pulse": 16}
    index_of(tmp_path, make_pairs(tmp_path, 2), scale=[1.0, 1.0])
    own = motion_suite.suite_sources(motions_of(suites=["near", str(tmp_path)]))
    assert [(each.name, each.count) for each in own] == [("near", 32), (tmp_path.name, 2)]
    with pytest.raises(InputError, match="different suites, got near, near"):
        motion_suite.suite_sources(motions_of(suites=["near", "near"]))
    with pytest.raises(InputError, match="nowhere does not exist"):
        motion_suite.suite_sources(motions_of(suites=["near", "nowhere"]))


@pytest.mark.parametrize("name", ["far", "pulse"])
def test_a_shipped_suite_is_generated_with_the_digests_of_its_index(name: str) -> None:
    entries, rule = list_motions(ROOT / "motions" / name), synthesis.SUITES[name]
    assert len(entries) == 16
    motion = motion_suite.read_entry(entries[0])  # refused where the digest differs
    place = (rule.scenario.magnitude, rule.scenario.distance_km)
    assert (motion.magnitude, motion.distance_km) == place
    assert motion.duration_s == pytest.approx(rule.shaking_s + 5.0, abs=0.02)
    assert ("pulse" in motion.event) is (name == "pulse")


def test_motions_keep_their_suite_and_number(tmp_path: Path) -> None:
    for name, letter in (("one", "a"), ("two", "b")):
        (folder := tmp_path / name).mkdir()
        index = index_of(folder, make_pairs(folder, 2), scale=[1.0, 1.0])
        index.write_text(index.read_text().replace("\nq", f"\n{letter}"))
    given = motions_of(suites=[str(tmp_path / "one"), str(tmp_path / "two")], count=None)
    motion_suite.write_suite(motion_suite.prepare_suites(given, t1_s=0.7), tmp_path / "s.parquet")
    back = motion_suite.read_suite(tmp_path / "s.parquet")
    found = [(each.suite, each.number, each.motion.motion_id[0]) for each in back]
    assert found == [("one", 0, "a"), ("one", 1, "a"), ("two", 0, "b"), ("two", 1, "b")]
    index.write_text(index.read_text().replace("\nb", "\na"))
    with pytest.raises(InputError, match="is in two suites"):
        motion_suite.prepare_suites(given, t1_s=0.7)


def demands(effects: dict[str, float], motions: int = 16) -> pd.DataFrame:
    """Demands without and with friction; drift changes by a factor of the suite, +- 3 %."""
    rng = np.random.default_rng(5)
    level_g = np.geomspace(0.1, 2.0, motions)
    parts = []
    for suite, effect in effects.items():
        table = synthetic_demands(motions=motions, skews=(30,), gaps=(25,))
        of_motion, of_run = rng.normal(size=(motions, 2)).T
        plain = 0.02 * level_g * np.exp(0.3 * of_motion)
        drift = np.append(plain, plain * effect * np.exp(0.03 * of_run))
        table = table[KEYS].assign(suite=suite, motion_id=suite + table["motion_id"])
        levels = {"im_saavg_rotd50_g": np.tile(level_g, 2)}
        parts.append(table.assign(**levels, column_drift_ratio=drift, unseating_m=2.0 * drift))
    return pd.concat(parts, ignore_index=True)


def test_a_difference_between_suites_is_found_with_its_interval() -> None:
    tables = fragility_tables(demands({"near": 0.95, "far": 0.80, "pulse": 0.95}), STATES, DEFAULTS)
    suites = tables["suites"]
    assert set(suites["quantity"]) == {"demand", "median_capacity"}
    given = {"medians": "median_effects", "intensities": "intensity_effects"}
    given |= {"effects": "effects", "curves": "curves"}
    answers = answer_table(**{name: tables[key] for name, key in given.items()})
    title, _ = suites_summary(suites, answers)
    assert title == "The effect of friction depends on the motions."
    assert suites_summary(suites[suites["verdict"] != DEPENDS], answers)[0] == ""
    assert suites_summary(suites[suites["against"] == ""], answers) == ("", "")
    drift = suites[suites["demand"] == "column_drift_ratio"]
    effects = drift[drift["against"] == ""].set_index("suite")
    assert list(effects.index) == ["near", "far", "pulse", ALL_SUITES]
    # the mean of all suites: (0.95 x 0.80 x 0.95)^(1/3) = 0.897
    assert effects.loc[["far", ALL_SUITES], "ratio"].tolist() == pytest.approx([0.8, 0.897], 0.03)
    pairs = drift[drift["against"] != ""].set_index(["suite", "against"])
    verdicts = {("far", "near"): DEPENDS, ("pulse", "far"): DEPENDS}
    assert pairs["verdict"].to_dict() == verdicts | {("pulse", "near"): NO_DIFFERENCE}
    row, both = pairs.loc[("far", "near")], effects.loc[["far", "near"]]
    assert row["ratio"] == pytest.approx(np.divide(*both["ratio"]), rel=1e-9)
    assert row["ci_low"] < 0.80 / 0.95 < row["ci_high"]
    # Welch's interval, from the intervals of both effects with 16 motions each
    share = 0.5 + 0.5 * row["level"]
    errors = np.log(both["ci_high"] / both["ratio"]) / stats.t.ppf(share, 15)
    error, dof = np.hypot(*errors), 15 * (errors**2).sum() ** 2 / (errors**4).sum()
    width = error * stats.t.ppf(share, dof)
    reach = np.log([row["ci_high"] / row["ratio"], row["ratio"] / row["ci_low"]])
    assert reach == pytest.approx(width, rel=1e-6)
    assert row["standard_errors"] == pytest.approx(-np.log(row["ratio"]) / error)
    assert (pairs["verdict"] == DEPENDS).tolist() == (pairs["standard_errors"] > 2.0).tolist()


def test_effects_without_a_ratio_are_not_compared() -> None:
    """Zero demands leave only differences, whose suites were said to differ by infinite errors."""
    table = demands({"near": 0.95, "far": 0.80})
    table["abutment_passive_m"] = 0.01 * table["column_drift_ratio"] * (table["friction"] == 0.0)
    tables = fragility_tables(table, STATES, DEFAULTS)
    passive = tables["effects"].query("demand == 'abutment_passive_m' and scope == 'pooled'")
    assert passive["status"].eq("ok").all()
    assert (passive["ratio"].isna() & passive["difference"].notna()).all()
    suites = tables["suites"]
    assert "abutment_passive_m" not in set(suites["demand"])
    assert np.isfinite(suites.loc[suites["against"] != "", "standard_errors"].astype(float)).all()


@pytest.fixture(scope="module")
def suite() -> pd.DataFrame:
    return motion_suite.prepare_suite(MOTIONS, count=SOME, t1_s=T1_S)


def test_generating_again_gives_the_shipped_files():
    """Same bytes on the processor the files were made on. Elsewhere the last digits of exp and sin
    may differ: values agree to 1e-6 of the peak."""
    for number, entry in enumerate(list_motions(MOTIONS)[:3], start=1):
        motion = synthesis.suite_motion(number, "near")
        assert motion.motion_id == entry.motion_id
        for component, (path, _) in enumerate(entry.components, start=1):
            made = synthesis.at2_text(motion, component).splitlines()
            kept = path.read_text().splitlines()
            assert made[:4] == kept[:4]
            values = [np.array(" ".join(lines[4:]).split(), float) for lines in (made, kept)]
            assert np.abs(values[0] - values[1]).max() <= 1e-6 * np.abs(values[1]).max()


def test_motions_end_with_5_s_at_rest_and_components_are_equally_strong_on_average(suite):
    assert len(suite) == SOME
    assert suite["scale"].between(*FACTOR_LIMITS).all()
    assert ((suite["npts"] - 1) * suite["dt_s"] <= 25.0).all()
    made = suite["motion_id"].isin([entry.motion_id for entry in MADE])
    both = [suite[f"accel_{component}_mps2"] for component in (1, 2)]
    for dt_s, is_made, *components in zip(suite["dt_s"], made, *both, strict=True):
        for accel in components:
            assert np.all(accel[-round(5.0 / dt_s) :] == 0.0)
            velocity = np.cumsum(accel) * dt_s
            # a sum of 2000 values rounded to 1e-7 g, four standard deviations of it
            rounding = 4.0 * 1e-7 * G_MPS2 * dt_s * np.sqrt(2000 / 12)
            assert abs(velocity[-1]) < (rounding if is_made else 1e-6 * np.abs(velocity).max())
    first, second = (part.map(lambda accel: np.abs(accel).max()) for part in both)
    # standard error of the mean ratio is about 0.3 / sqrt(40) = 0.05
    assert abs(np.log(first / second).mean()) < 0.15


def test_generated_motion_equals_its_files_on_any_processor(tmp_path, monkeypatch):
    """Last digits differ by 1e-14 g between processors; here by ten times as much."""
    made = motion_suite.read_entry(MADE[0])
    read = read_motion(*synthesis.write_at2(made, tmp_path))
    assert made.sha256 == read.sha256 == MADE[0].sha256
    assert (made.motion_id, made.dt_s) == (read.motion_id, read.dt_s)
    assert np.array(made.components).tobytes() == np.array(read.components).tobytes()
    with pytest.raises(InputError, match="different libraries"):
        motion_suite.read_entry(MADE[0].model_copy(update={"sha256": "0" * 64}))
    synthesize = synthesis.synthesize
    rng = np.random.default_rng(1)

    def elsewhere(*arguments: object, **options: object) -> record.GroundMotion:
        motion = synthesize(*arguments, **options)
        return motion.mapped(lambda accel: accel + rng.uniform(-1, 1, accel.size) * 1e-13 * G_MPS2)

    here = synthesis.made_motion(MADE[-1].made_from_number)
    monkeypatch.setattr(synthesis, "synthesize", elsewhere)
    there = synthesis.made_motion(MADE[-1].made_from_number)
    assert there.sha256 == here.sha256 == MADE[-1].sha256
    assert np.array(there.components).tobytes() == np.array(here.components).tobytes()


@pytest.mark.slow
def test_every_generated_motion_has_the_digest_of_the_index():
    for entry in MADE:
        motion_suite.read_entry(entry)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "motions"
    index = pd.read_csv(MOTIONS / "index.csv", dtype=str, keep_default_na=False)[39:42]
    for name in index[["file_1", "file_2"]].iloc[0]:
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_bytes((MOTIONS / name).read_bytes())
    index.assign(scale="1.5").to_csv(folder / "index.csv", index=False)
    return folder


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    numbers: list[int] = []
    make = synthesis.made_motion

    def counted(number: int, suite: str) -> object:
        numbers.append(number)
        return make(number, suite)

    monkeypatch.setattr(synthesis, "made_motion", counted)
    return numbers


def keys_of(folder: Path, count: int, results: Path) -> list[list[str]]:
    grid, motions = {"bridge": ["osb1"], "skew_deg": [30]}, {"folder": str(folder), "count": count}
    study = config.parse_config({"results": str(results), "grid": grid, "motions": motions})
    inputs.prepare_motions(study)
    tasks = analyses.StudySetup.of(study).tasks
    return [[*map(run_key, tasks(variant.slug))] for variant in expand_grid(study.grid)]


def test_more_motions_preserve_keys_and_generate_only_new_ones(folder, tmp_path, made):
    few = keys_of(folder, 1, tmp_path / "few")
    assert made == []
    many = keys_of(folder, 3, tmp_path / "many")
    assert made == [48, 49]
    assert [keys[:1] for keys in many] == few
    assert all(len(set(keys)) == 3 for keys in many)
    # factors of full blocks and the digest of a suite make no motion
    levels = {"t1_s": T1_S, "bands_g": ((0.2, 1.0),)}
    few, many = (motion_suite.prepare_suite(MOTIONS, count=count, **levels) for count in (1, 9))
    assert few["scale"][0] == many["scale"][0]
    before = motion_suite.content_digest(folder, 3, tmp_path / "digest.json")
    index = folder / "index.csv"
    index.write_text(index.read_text().replace(",48\n", ",51\n"))
    assert motion_suite.content_digest(folder, 3, tmp_path / "digest.json") != before
    assert made == [48, 49]


def test_check_generates_the_motion_keeps_its_index_row_and_refuses_another_number(folder) -> None:
    index = folder / "index.csv"
    before = index.read_text()
    found = answer("motions", "check", folder, "--write")
    assert "made" in {item["format"] for item in found["files"]}
    assert index.read_text().splitlines()[2:] == before.splitlines()[2:]
    for old, new in ((",48\n", ",0\n"), ("syn048,,", "syn048,a.AT2,")):  # number and files together
        assert old in before
        index.write_text(before.replace(old, new))
        assert "made_from_number" in str(answer("motions", "check", folder, code=2))


def test_analyses_end_with_the_strong_part_of_each_motion(folder, tmp_path):
    grid, motions = {"bridge": ["osb1"]}, {"folder": str(folder), "count": 1, "tail_ratio": 0.25}
    study = config.parse_config({"results": str(tmp_path), "grid": grid, "motions": motions})
    inputs.prepare_motions(study)
    setup = analyses.StudySetup.of(study)
    (task,) = setup.tasks("osb1_cf_skew30_gap051_mu050")
    end_s = intensity.shaken_s(task.motion.motion, 0.7192, 0.25)
    assert setup.durations_s == [task.analysed_s] == [task.settings.duration_s] == [end_s]
    assert end_s < task.motion.motion.duration_s


def test_a_pair_of_files_has_the_time_step_of_the_index_beside_them(tmp_path):
    paths = [tmp_path / f"bare_h{number}.txt" for number in (1, 2)]
    for path in paths:
        np.savetxt(path, 0.1 * np.sin(np.arange(200) / 9.0))
    with pytest.raises(InputError, match=r"state it in index\.csv"):
        motion_suite.read_pair(*paths)
    answer("motions", "check", tmp_path, "--write", "--dt-s", 0.02, "--unit", "m/s2")
    assert motion_suite.read_pair(*paths).dt_s == 0.02
    for files in (paths, paths[1:]):
        pga_g = answer("motions", "im", *files)["pga_h1_g"]
        assert pga_g == pytest.approx(0.1 / G_MPS2, rel=1e-3)
    assert motion_suite.read_pair(*paths[::-1]).files == ("bare_h2.txt", "bare_h1.txt")
    (tmp_path / "index.csv").unlink()
    assert answer("motions", "im", *paths, "--dt-s", 0.02, "--unit", "m/s2")["pga_h1_g"] == pga_g
    np.savetxt(paths[0], np.outer(np.sin(np.arange(200) / 9.0), [0.1, 0.2]))
    row = "motion_id,file_1,channel_1,file_2,channel_2,dt_s,unit\na,{0},1,{0},2,0.02,m/s2\n"
    (tmp_path / "index.csv").write_text(row.format(paths[0].name))
    refused = answer("motions", "im", paths[0], code=2)  # it was the second channel
    assert "has two channels in index.csv: give the file twice" in refused["message"]
    assert answer("motions", "im", paths[0], paths[0])["pga_h2_g"] == pytest.approx(2.0 * pga_g)

"""Suites of motions as a factor: sources, names, rows, effects by suite and their differences."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fragility_tables import synthetic_demands
from motions_files import index_of, make_pairs
from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.study_tables import ALL_SUITES, DEPENDS, NO_DIFFERENCE, fragility_tables
from skewbridge.motions.folder import list_motions
from skewbridge.motions.suite import (
    prepare_suites,
    read_entry,
    read_suite,
    suite_sources,
    write_suite,
)
from skewbridge.motions.synthesis.generate import SUITES
from skewbridge.report.answer import answer_table, suites_summary
from skewbridge.study.config import parse_config

ROOT = Path(__file__).parents[2]


def motions_of(**given: object):
    return parse_config({"motions": given}).motions


def test_suites_of_a_configuration(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.delenv("SKEWBRIDGE_RECORDS", raising=False)
    (default,) = suite_sources(motions_of())
    assert (default.name, default.folder, default.count) == ("near", Path("motions"), 32)
    shipped = suite_sources(motions_of(suites=["near", "far", "pulse", "records"]))
    assert [(each.name, each.count) for each in shipped] == [
        ("near", 32), ("far", 16), ("pulse", 16)
    ]  # fmt: skip
    index_of(tmp_path, make_pairs(tmp_path, 2), scale=[1.0, 1.0])
    monkeypatch.setenv("SKEWBRIDGE_RECORDS", str(tmp_path))
    records = suite_sources(motions_of(suites=["near", "records", str(tmp_path)]))
    assert [each.name for each in records] == ["near", "records", tmp_path.name]
    with pytest.raises(InputError, match="different suites, got near, near"):
        suite_sources(motions_of(suites=["near", "near"]))
    with pytest.raises(InputError, match="nowhere does not exist"):
        suite_sources(motions_of(suites=["near", "nowhere"]))


@pytest.mark.parametrize("name", ["far", "pulse"])
def test_a_shipped_suite_is_generated_with_the_digests_of_its_index(name: str) -> None:
    entries = list_motions(ROOT / "motions" / name)
    rule = SUITES[name]
    assert len(entries) == rule.count
    motion = read_entry(entries[0])  # refused where the digest differs
    assert motion.magnitude == rule.scenario.magnitude
    assert motion.distance_km == rule.scenario.distance_km
    assert motion.duration_s == pytest.approx(rule.shaking_s + 5.0, abs=0.02)
    assert ("pulse" in motion.event) is (name == "pulse")


def test_motions_keep_their_suite_and_number(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder, letter in zip(folders, "ab", strict=True):
        folder.mkdir()
        index_of(folder, make_pairs(folder, 2), scale=[1.0, 1.0])
        index = folder / "index.csv"
        index.write_text(index.read_text().replace("\nq", f"\n{letter}"))
    given = motions_of(folder=str(folders[0]), suites=["near", str(folders[1])], count=None)
    write_suite(prepare_suites(given, t1_s=0.7), tmp_path / "suite.parquet")
    found = [
        (each.suite, each.number, each.motion.motion_id[0])
        for each in read_suite(tmp_path / "suite.parquet")
    ]
    assert found == [("one", 0, "a"), ("one", 1, "a"), ("two", 0, "b"), ("two", 1, "b")]
    index.write_text(index.read_text().replace("\nb", "\na"))
    with pytest.raises(InputError, match="is in two suites"):
        prepare_suites(given, t1_s=0.7)


def demands(effects: dict[str, float], motions: int = 16) -> pd.DataFrame:
    """Demands without and with friction; drift changes by a factor of the suite, +- 3 %."""
    rng = np.random.default_rng(5)
    parts = []
    for suite, effect in effects.items():
        table = synthetic_demands(motions=motions, skews=(30,), gaps=(25,))
        level_g = np.geomspace(0.1, 2.0, motions)
        of_motion, of_run = rng.normal(size=(motions, 2)).T
        plain = 0.02 * level_g * np.exp(0.3 * of_motion)
        drift = np.append(plain, plain * effect * np.exp(0.03 * of_run))
        table = table[KEYS].assign(suite=suite, motion_id=suite + table["motion_id"])
        levels = {"im_saavg_rotd50_g": np.tile(level_g, 2)}
        parts.append(table.assign(**levels, column_drift_ratio=drift, unseating_m=2.0 * drift))
    return pd.concat(parts, ignore_index=True)


KEYS = ["variant", "bridge", "abutment", "skew_deg", "gap_mm", "friction", "motion_id", "scale",
        "incidence_deg", "status"]  # fmt: skip


STATES = [
    LimitState(
        component="unseating", name="slight", demand="unseating_m", threshold=0.038,
        dispersion=0.3, citation="test",
    )
]  # fmt: skip


def test_a_difference_between_suites_is_found_with_its_interval() -> None:
    tables = fragility_tables(demands({"near": 0.95, "far": 0.80, "pulse": 0.95}), STATES, DEFAULTS)
    suites = tables["suites"]
    drift = suites[suites["demand"] == "column_drift_ratio"]
    effects = drift[drift["against"] == ""].set_index("suite")
    assert list(effects.index) == ["near", "far", "pulse", ALL_SUITES]
    assert effects.loc["far", "ratio"] == pytest.approx(0.80, rel=0.03)
    assert effects.loc[ALL_SUITES, "ratio"] == pytest.approx(0.897, rel=0.03)
    pairs = drift[drift["against"] != ""].set_index(["suite", "against"])
    assert pairs.loc[("far", "near"), "verdict"] == DEPENDS
    assert pairs.loc[("pulse", "far"), "verdict"] == DEPENDS
    assert pairs.loc[("pulse", "near"), "verdict"] == NO_DIFFERENCE
    row = pairs.loc[("far", "near")]
    assert row["ratio"] == pytest.approx(
        effects.loc["far", "ratio"] / effects.loc["near", "ratio"], rel=1e-9
    )
    assert row["ci_low"] < 0.80 / 0.95 < row["ci_high"]
    # the interval of Welch from those of both effects, of 16 motions each
    both = effects.loc[["far", "near"]]
    errors = np.log(both["ci_high"] / both["ratio"]) / stats.t.ppf(0.5 + 0.5 * row["level"], 15)
    error, dof = np.hypot(*errors), 15 * (errors**2).sum() ** 2 / (errors**4).sum()
    width = error * stats.t.ppf(0.5 + 0.5 * row["level"], dof)
    assert np.log(row["ci_high"] / row["ratio"]) == pytest.approx(width, rel=1e-6)
    assert np.log(row["ratio"] / row["ci_low"]) == pytest.approx(width, rel=1e-6)
    assert row["standard_errors"] == pytest.approx(-np.log(row["ratio"]) / error)
    assert (pairs["verdict"] == DEPENDS).tolist() == (pairs["standard_errors"] > 2.0).tolist()
    assert set(suites["quantity"]) == {"demand", "median_capacity"}
    medians = tables["suite_curves"]
    assert set(medians["suite"]) == {"near", "far", "pulse"}
    assert medians["theta"].between(0.5, 1.5).all()


def test_effects_without_a_ratio_are_not_compared() -> None:
    """Zero demands leave only differences, whose suites were said to differ by infinite errors."""
    table = demands({"near": 0.95, "far": 0.80})
    table["abutment_passive_m"] = 0.01 * table["column_drift_ratio"] * (table["friction"] == 0.0)
    tables = fragility_tables(table, STATES, DEFAULTS)
    effects = tables["effects"]
    passive = effects[(effects["demand"] == "abutment_passive_m") & (effects["scope"] == "pooled")]
    assert passive["status"].eq("ok").all()
    assert passive["ratio"].isna().all()
    assert passive["difference"].notna().all()
    suites = tables["suites"]
    assert "abutment_passive_m" not in set(suites["demand"])
    assert np.isfinite(suites.loc[suites["against"] != "", "standard_errors"].astype(float)).all()


def test_the_first_screen_states_the_difference() -> None:
    def summary(effects: dict[str, float]) -> tuple[str, str]:
        tables = fragility_tables(demands(effects), STATES, DEFAULTS)
        table = answer_table(
            medians=tables["median_effects"],
            effects=tables["effects"],
            intensities=tables["intensity_effects"],
            curves=tables["curves"],
        )
        return suites_summary(tables["suites"], table)

    title, text = summary({"near": 0.95, "far": 0.80})
    assert title == "; the effect of friction depends on the motions"
    assert "under near" in text
    assert "by chance about 0" in text
    title, text = summary({"near": 0.95, "far": 0.95})
    assert title == ""
    assert text.startswith("Suites near (16) and far (16): 0 of ")
    assert summary({"near": 0.95}) == ("", "")

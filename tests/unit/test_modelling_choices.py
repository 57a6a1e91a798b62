"""Modelling choices: table, pairs, ratios, journal, figure and findings."""

from collections.abc import Sequence
from dataclasses import fields, replace
from math import exp, log
from pathlib import Path

import pandas as pd
import pytest

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.columns import demands_for
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.errors import InputError
from skewbridge.files.digests import provenance
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.report.effect_figures import (
    choice_findings,
    choices_left_out,
    tornado,
    tornado_text,
)
from skewbridge.study.analyses import StudySetup, sampled
from skewbridge.study.batch import Workers
from skewbridge.study.config import chosen_variants, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.modelling_choices import (
    CHOICE_COLUMNS,
    CHOICES,
    Choice,
    axis_pairs,
    choice_pairs,
    choices_table,
    friction_split,
    write_choices,
)
from skewbridge.study.products import rule_digest
from skewbridge.study.session import Job
from skewbridge.study.task import Task, run_key
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.options import ModelOptions
from study_parts import study_of, wave

SLUG = "osb1_cf_skew30_gap025_mu050"
AXES = {"skew_deg": (0.0, 30.0), "gap_mm": (25.0,), "friction": (0.0, 0.5)}


def setup_in(folder: Path, *, motions: int = 1) -> StudySetup:
    """A study of weak waves that differ by their factor."""
    waves = (wave(f"wave{n}", number=n, scale=1.0 + n) for n in range(motions))
    return study_of(folder, *waves)


@pytest.fixture
def task(tmp_path: Path) -> Task:
    return setup_in(tmp_path).tasks(SLUG)[0]


def at(task: Task, **changes: object) -> Task:
    """The same analysis of another variant."""
    return replace(task, variant=replace(task.variant, **changes).normalised())


def tried(task: Task) -> set[str]:
    return {pair.name for pair in choice_pairs([task])}


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: choice.key)
def test_every_choice_is_an_option_with_values_that_it_takes(choice: Choice, task: Task) -> None:
    kind = AnalysisSettings if choice.section == "analysis" else ModelOptions
    assert choice.key in {field.name for field in fields(kind)}
    assert choice.label
    assert choice.source
    part = "settings" if choice.section == "analysis" else "options"
    for value in choice.values:
        assert getattr(getattr(choice.set_in(task, value), part), choice.key) == value


def test_the_configured_value_is_never_compared_with_itself(task: Task) -> None:
    for choice in CHOICES:
        for value in choice.values:
            own = choice.set_in(task, value)
            others = choice.alternatives(own)
            assert value not in others
            keys = {run_key(choice.set_in(own, other)) for other in others}
            assert run_key(own) not in keys
            assert len(keys) == len(others)


def test_null_counts_as_the_default_value(task: Task) -> None:
    values = {choice.key: choice.alternatives(task) for choice in CHOICES}
    assert values["damping_ratio"] == [0.02]  # the file has 0.05
    assert task.settings.integrator_command not in values["integrator"]
    assert values["integrator"]


def test_choices_that_do_not_act_on_a_variant_are_left_out(task: Task) -> None:
    everywhere = {"column_integration", "damping_ratio", "integrator", "cap_load", "fiber_end"}
    everywhere |= {"shear_model", "shear_failure"}
    assert tried(at(task, abutment="roller")) == everywhere
    assert {"key_frame", "gap_measured", "backfill_variation"} <= tried(task)
    assert not {"key_frame", "gap_measured", "backfill_variation"} & tried(at(task, skew_deg=0))
    assert "embankment_mass" in tried(at(task, abutment="spring"))
    assert not {"embankment_mass", "foundation"} & tried(task)
    assert "foundation" in tried(at(task, bridge="bridge_a"))
    assert "friction_at" in tried(task)
    assert "friction_at" not in tried(at(task, friction_pct=0))
    assert "hinge_rule" in tried(at(task, bridge="osb1_fixed"))
    assert "hinge_rule" not in tried(task)  # its hinges are longer than the limit


def test_settings_fixed_by_the_scheme_are_not_tried(task: Task) -> None:
    paper = replace(task, settings=AnalysisSettings(scheme="paper"))
    assert "column_integration" in tried(task)
    assert "column_integration" not in tried(paper)
    assert "shear_failure" not in tried(paper), "softening needs a hinge of a given length"


def test_motions_are_spread_over_their_strength(tmp_path: Path) -> None:
    tasks = setup_in(tmp_path, motions=8).tasks(SLUG)
    strength = {task.motion.motion.motion_id: place for place, task in enumerate(ranked(tasks))}
    found = [strength[task.motion.motion.motion_id] for task in sampled(tasks, 4)]
    assert found == [1, 3, 5, 7]
    assert len(sampled(tasks, 20)) == 8


def ranked(tasks: list[Task]) -> list[Task]:
    return sorted(tasks, key=lambda task: task.motion.measures["im_pgv_rotd50_mps"])


def test_axes_go_from_end_to_end_and_one_value_is_none(tmp_path: Path) -> None:
    pairs = list(axis_pairs(setup_in(tmp_path), SLUG, AXES, 1))
    ends = [(pair.name, pair.before.variant.slug, pair.after.variant.slug) for pair in pairs]
    assert ends == [
        ("skew_deg", "osb1_cf_skew00_gap025_mu050", SLUG),
        ("friction", "osb1_cf_skew30_gap025_mu000", SLUG),
    ]
    assert (pairs[0].from_value, pairs[0].to_value) == ("0 deg", "30 deg")
    assert not list(
        axis_pairs(
            setup_in(tmp_path), "osb1_ro_skew00_gap000_mu000", AXES | {"skew_deg": (0.0,)}, 1
        )
    )


def test_two_variants_of_each_bridge_are_changed_by_default() -> None:
    grid = GridConfig(bridge=("osb1", "osb2s"), skew_deg=(0, 30, -60), gap_mm=(25, 51))
    assert chosen_variants(expand_grid(grid), ()) == [
        "osb1_cf_skew30_gap025_mu050",
        "osb1_cf_skewm60_gap025_mu050",
        "osb2s_cf_skew30_gap025_mu050",
        "osb2s_cf_skewm60_gap025_mu050",
    ]


def test_named_variants_must_be_of_a_bridge_of_the_grid() -> None:
    variants = expand_grid(GridConfig())
    assert chosen_variants(variants, [SLUG, SLUG]) == [SLUG]
    with pytest.raises(InputError, match="osb2s is not a bridge of the grid"):
        chosen_variants(variants, ["osb2s_cf_skew30_gap025_mu050"])
    with pytest.raises(InputError):
        parse_config({"modelling_choices": {"motions": 0}})


def outcome(value: float, status: str = "ok") -> dict[str, object]:
    return {column.name: value for column in DEMAND_COLUMNS} | {"status": status}


def test_ratios_are_paired_by_motion_and_failed_runs_are_counted(tmp_path: Path) -> None:
    tasks = setup_in(tmp_path, motions=4).tasks(SLUG)
    frame = next(choice for choice in CHOICES if choice.key == "key_frame")
    pairs = list(choice_pairs(tasks, [frame]))
    outcomes = ((1.0, 2.0, "ok"), (10.0, 5.0, "ok"), (3.0, 12.0, "ok"), (1.0, 9.0, "collapse"))
    rows: dict[str, dict[str, object]] = {}
    for pair, (before, after, status) in zip(pairs, outcomes, strict=True):
        rows[run_key(pair.before)] = outcome(before)
        rows[run_key(pair.after)] = outcome(after, status)
    rows[run_key(pairs[2].after)]["unseating_m"] = 0.0
    table = choices_table([*pairs, pairs[0]], rows)
    assert list(table.columns) == list(CHOICE_COLUMNS)
    assert list(table["demand"]) == list(demands_for("effect"))
    by_demand = table.set_index("demand")
    drift = by_demand.loc["column_drift_ratio"]
    assert drift["ratio"] == pytest.approx((2.0 * 0.5 * 4.0) ** (1 / 3))
    assert (drift["lowest"], drift["highest"]) == pytest.approx((0.5, 4.0))
    assert (drift["n"], drift["n_failed"], drift["n_pairs"]) == (3, 1, 4)
    unseating = by_demand.loc["unseating_m"]
    assert unseating["ratio"] == pytest.approx(exp((log(2.0) + log(0.5)) / 2))
    assert (unseating["n"], unseating["n_failed"]) == (2, 1)
    assert (drift["from_value"], drift["to_value"]) == ("deck edge", "skewed")


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Keys of the analyses that workers were asked for; their demands depend on the variant."""
    asked: list[str] = []

    def stream(_pool: object, pending: Sequence[tuple[int, Task, str]]):
        for number, task, key in pending:
            asked.append(str(key))
            value = 1.1 if task.variant.friction_pct else 1.0
            if task.variant.friction_pct:
                value = {"walls": 1.02, "keys": 1.08}.get(task.options.friction_at, value)
            value *= 0.8 if task.options.key_frame == "deck_edge" else 1.0
            row = outcome(value) | {"run_key": key, "variant": task.variant.slug}
            yield number, [row]

    monkeypatch.setattr("skewbridge.study.batch._Pool.stream", stream)
    return asked


def made(setup: StudySetup, name: str = "table") -> pd.DataFrame:
    path = setup.folder.root / f"{name}.parquet"
    write_choices(setup, [SLUG], AXES, motions=2, workers=Workers(count=1), output=path)
    return read_frame(path)


def test_finished_analyses_are_not_run_again(tmp_path: Path, ran: list[str]) -> None:
    """Neither those of an earlier call nor those in the journals of the study."""
    setup, other = (setup_in(tmp_path / name, motions=3) for name in ("one", "other"))
    first = made(setup)
    everything = len(ran)
    assert everything == len(set(ran)) > 20
    pd.testing.assert_frame_equal(made(setup, "again"), first)
    assert len(ran) == everything
    own = setup.folder.journal("modelling_choices").read_text()
    without = "osb1_cf_skew30_gap025_mu000"
    journal = other.folder.journal(without)
    journal.parent.mkdir(parents=True)
    journal.write_text("\n".join(line for line in own.splitlines() if without in line))
    ran.clear()
    made(other)
    assert len(ran) == everything - 2


def test_only_a_current_table_is_shown(tmp_path: Path) -> None:
    path, this = tmp_path / "table.parquet", {"sources": "a"}
    job = Job(
        study=parse_config({}),
        folder=StudyFolder(tmp_path),
        inputs={},
        outputs={},
        workers=Workers(count=1),
        stamp={},
    )
    assert job.current(path, this) is None
    write_frame(pd.DataFrame({"x": [1]}), path, provenance(rule_digest=rule_digest(this)))
    assert job.current(path, this) == path
    assert job.current(path, {"sources": "b"}) is None


def test_the_page_says_which_choices_move_a_demand_more_than_friction(
    tmp_path: Path, ran: list[str]
) -> None:
    table = made(setup_in(tmp_path))
    finding = choice_findings(table)[1]
    assert finding == (
        "Column drift ratio: friction 0 → 0.5 moves it by +10.0 %; more than that do "
        "Key frame deck edge → skewed (+25.0 %)."
    )
    without = table[table["name"] != "key_frame"]
    assert choice_findings(without)[1].endswith("no choice tried moves it more.")
    assert not choice_findings(table[table["name"] != "friction"])
    assert "Key frame" in choices_left_out(without)
    assert "Key frame" not in choices_left_out(table)


def test_the_tornado_has_a_bar_per_value_the_largest_on_top(tmp_path: Path, ran: list[str]) -> None:
    table = made(setup_in(tmp_path))
    figure = tornado(table)
    values = table[["name", "to_value"]].drop_duplicates()
    panels = [panel for panel in figure.axes if panel.patches]
    assert len(panels) == len(demands_for("headline"))
    assert "over up to 1 pairs of runs" in tornado_text(table)
    for panel in panels:
        labels = [label.get_text() for label in panel.get_yticklabels()]
        assert len(labels) == len(panel.patches) == len(values)
        assert labels[-2:] == ["Friction 0 → 0.5", "Key frame deck edge → skewed"]


def test_the_effect_of_friction_is_divided_between_walls_and_keys(
    tmp_path: Path, ran: list[str]
) -> None:
    table = made(setup_in(tmp_path, motions=2))
    rows = table[(table["name"] == "friction") & (table["demand"] == "unseating_m")]
    assert dict(zip(rows["to_value"], rows["ratio"], strict=True)) == pytest.approx(
        {"0.5": 1.1, "0.5 at walls": 1.02, "0.5 at keys": 1.08}
    )
    assert set(rows["from_value"]) == {"0"}
    # all motions have the same ratio here
    assert list(rows["ci_low"]) == pytest.approx(list(rows["ratio"]))
    assert set(rows["n"]) == {2}
    assert not list(friction_split(setup_in(tmp_path), SLUG, {"friction": (0.2, 0.5)}, 1))


def test_the_interval_of_a_ratio_is_that_of_the_means_of_the_motions(tmp_path: Path) -> None:
    """ln 2, ln 3 and ln 6 of three motions: t(0.95, 2) = 2.919986."""
    tasks = setup_in(tmp_path, motions=3).tasks(SLUG)
    frame = next(choice for choice in CHOICES if choice.key == "key_frame")
    pairs = list(choice_pairs(tasks, [frame]))
    rows = {
        run_key(task): outcome(value)
        for pair, ratio in zip(pairs, (2.0, 3.0, 6.0), strict=True)
        for task, value in ((pair.before, 1.0), (pair.after, ratio))
    }
    row = choices_table(pairs, rows).iloc[0]
    logs = [log(2.0), log(3.0), log(6.0)]
    mean = sum(logs) / 3
    reach = 2.919986 * (sum((each - mean) ** 2 for each in logs) / 2 / 3) ** 0.5
    assert (row["ci_low"], row["ci_high"]) == pytest.approx((exp(mean - reach), exp(mean + reach)))

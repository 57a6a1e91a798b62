"""Modelling choices, random properties, alternatives: pairs, ratios, findings, draws, effects."""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from math import exp, log
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from reference_pages import ROOT
from scipy import special

from skewbridge.analysis.model_script import model_script
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge import backfill, structures
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import core_concrete, steel_of
from skewbridge.demands.columns import DEMAND_COLUMNS, choice_text, columns_with, demands_for
from skewbridge.demands.tables import join_variants, write_variant
from skewbridge.errors import InputError
from skewbridge.files import tables
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.fragility.alternatives import alternative_effects
from skewbridge.report.answer import alternative_rows, properties_sentence
from skewbridge.report.fragility_figures import choice_findings, tornado
from skewbridge.study import jobs, modelling_choices
from skewbridge.study.analyses import StudySetup, sampled
from skewbridge.study.config import parse_config
from skewbridge.study.results import statistics_of
from skewbridge.study.task import Task, run_key
from skewbridge.variant import random_properties, variant
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import RandomProperty, UncertaintyConfig, with_draw
from study_parts import row_of, study_of, wave, without_workers

SLUG = "osb1_cf_skew30_gap025_mu050"
AXES = {"skew_deg": (0.0, 30.0), "gap_mm": (25.0,), "friction": (0.0, 0.5)}
MODELS = (
    {}, {"skew_deg": 0}, {"bridge": "bridge_a"}, {"bridge": "osb1_fixed"},
    {"abutment": "spring", "friction_pct": 0}, {"abutment": "roller"},
)  # fmt: skip


def setup_in(folder: Path, *, motions: int = 1) -> StudySetup:
    waves = (wave(f"wave{n}", number=n, scale=1.0 + n) for n in range(motions))
    grid = GridConfig(bridge=("osb1", "osb1_fixed"), abutment=("contact_friction", "roller"))
    return study_of(folder, *waves, grid=grid)


@pytest.fixture
def task(tmp_path: Path) -> Task:
    return setup_in(tmp_path).tasks(SLUG)[0]


def at(task: Task, **changes: object) -> Task:
    return replace(task, variant=replace(task.variant, **changes).normalised())


def test_choices_that_do_not_act_on_a_variant_are_left_out(task: Task) -> None:
    def tried(task: Task) -> set[str]:
        return {labels["name"] for labels, *_ in modelling_choices.choice_pairs([task])}

    # the spacing of columns needs skewed bents with more than one column
    straight = at(task, skew_deg=0)
    for own in ({"bent_skew": "square"}, {"bent_skew_deg": 0.0}):
        assert "column_spacing" not in tried(replace(task, options=replace(task.options, **own)))
    turned = replace(straight, options=replace(task.options, bent_skew_deg=20.0))
    assert "column_spacing" in tried(turned)
    assert "bent_skew" not in tried(turned), "a given skew of the bents overrides the option"
    assert "friction_at" not in tried(at(task, friction_pct=0))
    # softening needs a hinge of a given length
    paper = replace(task, settings=AnalysisSettings(scheme="paper"))
    assert not {"column_integration", "shear_failure"} & tried(paper)


def built(task: Task) -> tuple[str, ...]:
    settings, options = task.settings, task.settings.model_options(task.options)
    commands = re.sub(r"-0\.0\b", "0.0", model_script(task.variant, options))
    return commands, str(settings), options.shear_model


@pytest.mark.parametrize(
    "choice", modelling_choices.CHOICES, ids=lambda choice: f"{choice.key} {choice.values[0]}"
)
def test_a_choice_changes_the_models_on_which_it_acts_and_no_other(choice, task) -> None:
    assert choice.source
    part = "settings" if choice.section == "analysis" else "options"
    for value in choice.values:
        own = choice.set_in(task, value)
        assert getattr(getattr(own, part), choice.key) == value
        assert value not in choice.alternatives(own)
    # null counts as the default value
    values = choice.alternatives(task)
    assert choice.key != "damping_factor" or values == [0.4]
    assert choice.key != "integrator" or task.settings.integrator_command not in values
    acted = 0
    for changes in MODELS:
        own = at(task, **changes)
        configured, alternatives = built(own), choice.alternatives(own)
        changed = [choice.set_in(own, value) for value in alternatives]
        assert len({run_key(each) for each in (own, *changed)}) == 1 + len(changed)
        assert configured not in map(built, changed), changes
        acted += bool(alternatives)
        if not alternatives and all(getattr(own.options, k) == v for k, v in choice.needs.items()):
            same = [choice.set_in(own, value) for value in choice.values]
            assert {configured} == set(map(built, same)), changes
    assert acted


def test_motions_are_spread_over_their_strength_and_two_variants_changed(tmp_path: Path) -> None:
    tasks = setup_in(tmp_path, motions=8).tasks(SLUG)
    ranked = sorted(tasks, key=lambda task: task.motion.measures["im_pgv_rotd50_mps"])
    assert [ranked.index(task) for task in sampled(tasks, 4)] == [1, 3, 5, 7]
    assert len(sampled(tasks, 20)) == 8
    grid = GridConfig(bridge=("osb1", "osb2s"), skew_deg=(0, 30, -60), gap_mm=(25, 51))
    names = [f"{bridge}_cf_skew{skew}_gap025_mu050"
             for bridge in ("osb1", "osb2s") for skew in ("30", "m60")]  # fmt: skip
    assert modelling_choices.chosen_variants(expand_grid(grid)) == names


def test_axes_go_from_end_to_end_and_one_value_is_none(tmp_path: Path) -> None:
    setup = setup_in(tmp_path)
    pairs = list(modelling_choices.axis_pairs(setup, SLUG, AXES, 1))
    ends = [(labels["name"], *(each.variant.slug for each in both)) for labels, *both in pairs]
    assert ends == [("skew_deg", "osb1_cf_skew00_gap025_mu050", SLUG),
                    *[("friction", "osb1_cf_skew30_gap025_mu000", SLUG)] * 3]  # fmt: skip
    friction = [(labels["to_value"], after.options.friction_at) for labels, _, after in pairs[1:]]
    assert friction == [("0.5", "all"), ("0.5 at walls", "walls"), ("0.5 at keys", "keys")]
    assert [*pairs[0][0].values()] == ["axis", "skew_deg", "0 deg", "30 deg"]
    one_skew = AXES | {"skew_deg": (0.0,)}
    assert not list(modelling_choices.axis_pairs(setup, "osb1_ro_skew00_gap000_mu000", one_skew, 1))
    axes = {"friction": (0.2, 0.5), "skew_deg": (-30.0, 30.0)}  # also values of equal size
    assert len(list(modelling_choices.axis_pairs(setup, SLUG, axes, 1))) == 2


def frame_pairs(folder: Path, outcomes: Sequence[tuple]) -> tuple[list, dict[str, dict]]:
    """Pairs of the frame of the keys, a motion each, and their rows: before, after, status."""

    def outcome(value: float, status: str = "ok") -> dict[str, object]:
        return {c.name: value for c in DEMAND_COLUMNS} | {"status": status, "beyond_model": ""}

    frame = next(choice for choice in modelling_choices.CHOICES if choice.key == "key_frame")
    tasks = setup_in(folder, motions=len(outcomes)).tasks(SLUG)
    pairs = list(modelling_choices.choice_pairs(tasks, [frame]))
    rows = {}
    for (_, one, other), (before, *after) in zip(pairs, outcomes, strict=True):
        rows |= {run_key(one): outcome(before), run_key(other): outcome(*after)}
    return pairs, rows


def test_ratios_are_paired_by_motion_with_the_interval_of_the_means_of_motions(tmp_path) -> None:
    outcomes = ((1.0, 2.0), (10.0, 5.0), (3.0, 12.0), (1.0, 9.0, "collapse"))
    pairs, rows = frame_pairs(tmp_path, outcomes)
    rows[run_key(pairs[2][2])]["unseating_m"] = 0.0
    table = modelling_choices.choices_table([*pairs, pairs[0]], rows)
    assert list(table.columns) == list(modelling_choices.CHOICE_COLUMNS)
    assert list(table["demand"]) == list(demands_for("effect"))
    by_demand = table.set_index("demand")
    drift = by_demand.loc["column_drift_ratio"]
    assert drift["ratio"] == pytest.approx((2.0 * 0.5 * 4.0) ** (1 / 3))
    assert (drift["lowest"], drift["highest"]) == pytest.approx((0.5, 4.0))
    assert (drift["n"], drift["n_failed"], drift["n_pairs"]) == (3, 1, 4)
    rows[run_key(pairs[2][2])]["beyond_model"] = "shear"  # its peaks are lower bounds
    bounded = modelling_choices.choices_table(pairs, rows).set_index("demand")
    assert bounded.loc["column_drift_ratio", ["n", "n_failed"]].tolist() == [2, 2]
    unseating = by_demand.loc["unseating_m"]
    assert unseating[["ratio", "n", "n_failed"]].tolist() == pytest.approx([1.0, 2, 1])  # 2 x 0.5
    assert (drift["from_value"], drift["to_value"]) == ("deck edge", "skewed")
    # ln 2, ln 3 and ln 6 of three motions: t(0.95, 2) = 2.919986.
    three = frame_pairs(tmp_path, ((1.0, 2.0), (1.0, 3.0), (1.0, 6.0)))
    row = modelling_choices.choices_table(*three).iloc[0]
    logs = np.log([2.0, 3.0, 6.0])
    ends = np.exp(logs.mean() + 2.919986 * np.array([-1, 1]) * logs.std(ddof=1) / 3**0.5)
    assert (row["ci_low"], row["ci_high"]) == pytest.approx(tuple(ends))


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[Task]:
    def answer(task: Task) -> dict:
        value = 0.8 if task.options.key_frame == "deck_edge" else 1.0
        if task.variant.friction_pct:
            value *= {"walls": 1.02, "keys": 1.08}.get(task.options.friction_at, 1.1)
        return row_of(task, value)

    return without_workers(monkeypatch, answer)


def made(setup: StudySetup, name: str = "table") -> pd.DataFrame:
    path = setup.folder.root / f"{name}.parquet"
    modelling_choices.write_choices(setup, [SLUG], AXES, path, 2)
    return read_frame(path)


def test_finished_analyses_are_not_run_again(tmp_path: Path, ran: list[Task]) -> None:
    setup = setup_in(tmp_path, motions=3)
    first = made(setup)
    everything = len(ran)
    assert everything == len(set(map(run_key, ran))) > 20
    pd.testing.assert_frame_equal(made(setup, "again"), first)
    assert len(ran) == everything


def test_only_a_current_table_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "table.parquet"
    job = jobs.Job(study=parse_config({}), inputs={}, outputs={}, threads=1, stamp={})
    assert job.current(path, {"sources": "a"}) is None
    write_frame(pd.DataFrame(), path, {"rule_digest": jobs.rule_digest({"sources": "a"})})
    assert [job.current(path, {"sources": each}) for each in "ab"] == [path, None]


@pytest.mark.parametrize(("processors", "workers"), [("1", 1), ("2", 1), ("4", 2)])
def test_in_a_study_of_few_variants_a_job_has_a_worker_more(processors, workers, monkeypatch):
    monkeypatch.setattr(StudySetup, "of", lambda study, count: count)
    monkeypatch.setenv("SKEWBRIDGE_PROCESSORS", processors)
    nothing = {"inputs": {}, "outputs": {}, "stamp": {}}
    assert jobs.Job(study=parse_config({}), threads=1, **nothing).setup == workers  # 24 variants


def test_findings_and_tornado_list_choices_that_move_a_demand_more_than_friction(tmp_path, ran):
    table = made(setup_in(tmp_path))
    assert choice_findings(table)[1] == (
        "Column drift ratio: friction 0 → 0.5 changes it by +10.0 %; larger changes: "
        "Key frame deck edge → skewed (+25.0 %)."
    )
    without = table[table["name"] != "key_frame"]
    assert choice_findings(without)[1].endswith("no choice changes it more.")
    assert not choice_findings(table[table["name"] != "friction"])
    for panel in tornado(table).axes[: len(demands_for("headline"))]:  # the largest on top
        labels = [label.get_text() for label in panel.get_yticklabels()]
        assert labels[-2:] == ["Friction 0 → 0.5", "Key frame deck edge → skewed"]


ANY_DIRECTION = RandomProperty(distribution="uniform", low=0.0, high=360.0, source="test")
ON = UncertaintyConfig(enabled=True, incidence_deg=ANY_DIRECTION)
NAMES = list(ON.properties)
IDS = [f"m{number:04d}" for number in range(2000)]
AT = {"skew_deg": 30, "gap_mm": 25, "friction": 0.5}


def expected(what: RandomProperty, value: float) -> float:
    """Share of a truncated distribution below a value, in closed form."""

    def normal(at: float) -> float:
        ratio = log(at / what.median) if what.distribution == "lognormal" else at - what.median
        return float(special.ndtr(ratio / what.spread))

    if what.distribution == "uniform":
        return (value - what.low) / (what.high - what.low)
    low, high = normal(what.low), normal(what.high)
    return (normal(value) - low) / (high - low)


@cache
def draws() -> dict[str, dict[str, float]]:
    return ON.draws(IDS)


def test_each_block_of_draws_is_a_latin_hypercube_that_more_motions_do_not_change() -> None:
    rows = np.array([list(draw.values()) for draw in draws().values()])
    for start in range(0, 160, random_properties.BLOCK):
        block = rows[start : start + random_properties.BLOCK]
        for name, column in zip(NAMES, block.T, strict=True):
            shares = [expected(ON.drawn[name], value) for value in column]
            # six digits of a value are kept
            steps = np.floor(np.array(shares) * len(block) * (1.0 - 1e-9))
            assert sorted(steps) == list(range(len(block))), name
    assert np.abs(np.corrcoef(rows.T) - np.eye(len(NAMES))).max() < 0.08
    few = ON.draws(IDS[:5])
    assert few == {name: draws()[name] for name in IDS[:5]}
    without = replace(ON, deck_mass_factor=None, gap_offset_mm=None).draws(IDS[:5])
    for name, draw in without.items():
        assert draw == {key: value for key, value in few[name].items() if key in draw}
        assert len(draw) == len(NAMES) - 2
    assert ON.draws(IDS[:5], suite="far") != few
    assert UncertaintyConfig().draws(IDS) == {}


def test_without_draws_a_bridge_is_that_of_its_file(tmp_path) -> None:
    for name in ("osb1", "osb1_fixed", "bridge_a", "osb2s"):
        assert structures.built_bridge(load_bridge(name), ModelOptions()) == load_bridge(name)
    passive = backfill.Passive(stiffness_n_per_m=3.0e7, ultimate_n=4.0e6, failure_ratio=0.7)
    assert passive.scaled(1.0, 1.0) == passive
    (task,) = study_of(tmp_path).tasks(SLUG)
    assert (task.options, task.incidence_deg) == (ModelOptions(), 0.0)
    assert not random_properties.drawn_properties(row_of(task))
    # a modelling choice keeps the draw of the motion
    choice = next(each for each in modelling_choices.CHOICES if each.key == "pad_strength_factor")
    (task,) = study_of(tmp_path, draws=ON.draws(["wave"])).tasks(SLUG)
    assert choice.configured_in(task) == 1.0
    changed = choice.set_in(task, 2.0).options.pad_strength_factor
    assert changed == pytest.approx(2.0 * task.draw["pad_strength_factor"])


def test_factors_act_on_the_model() -> None:
    options = ModelOptions(
        concrete_strength_factor=1.21, steel_strength_factor=1.1, deck_mass_factor=0.9,
        pad_stiffness_factor=0.5, pad_strength_factor=0.8, key_strength_factor=1.3,
        gap_offset_mm=-5.0,
    )  # fmt: skip
    usual = load_bridge("osb1")
    scaled = structures.built_bridge(usual, options)
    before, after = usual.column, scaled.column
    assert after.elastic_modulus_gpa == pytest.approx(1.1 * before.elastic_modulus_gpa)
    assert steel_of(after).yield_pa == pytest.approx(1.1 * steel_of(before).yield_pa)
    assert core_concrete(after).peak_pa > 1.15 * core_concrete(before).peak_pa
    keys_kn = [each.abutment.sacrificial_key.force_kn[1] for each in (usual, scaled)]
    assert keys_kn[1] == pytest.approx(1.3 * keys_kn[0])
    spans = load_bridge(ROOT / "docs/bridges/simple_spans.yaml")
    pads = structures.built_bridge(spans, options).joints[2].pads
    assert (pads.shear_stiffness_kn_per_m, pads.yield_force_kn) == pytest.approx((750.0, 48.0))
    weights_n = []
    for each in (ModelOptions(), options):
        with domain():
            model = build(variant.Variant.at("osb1", "contact_friction", AT), each)
            weights_n.append(model.weight_n)
            gaps_m = [side.gap_m for side in model.abutments]
    assert 0.9 < weights_n[1] / weights_n[0] < 0.92  # columns keep their weight
    assert gaps_m == pytest.approx([0.020, 0.020])


VALUES = {"key_frame": ("deck_edge", "skewed"), "foundation": ("springs", "fixed"),
          "backfill_vs_mps": (50.0, 150.0, 500.0)}  # fmt: skip
ALTERNATING = UncertaintyConfig(enabled=True, alternatives=VALUES)
MOTION_IDS = [f"m{number}" for number in range(32)]
FRAMES, SPEEDS = {"key_frame": ["skewed", "deck_edge"]}, {"backfill_vs_mps": [50, 150]}


def test_values_are_drawn_equally_often_and_change_no_property() -> None:
    draws = ALTERNATING.draws(MOTION_IDS)
    for name, values in VALUES.items():
        drawn = [draw[name] for draw in draws.values()]
        counts = np.array([[block.count(v) for v in values] for block in (drawn[:16], drawn[16:])])
        assert (counts.sum(axis=1) == 16).all()
        assert (np.ptp(counts, axis=1) <= 1).all(), name
    plain = replace(ALTERNATING, alternatives={}).draws(MOTION_IDS)
    for motion, draw in draws.items():
        assert {name: draw[name] for name in draw if name not in VALUES} == plain[motion]
    assert [*draws["m0"]][-3:] == [*VALUES]
    assert ALTERNATING.draws(MOTION_IDS[:3]) == {name: draws[name] for name in MOTION_IDS[:3]}


def test_bad_alternatives_are_refused() -> None:
    for alternatives, sections, message in (
        ({"key_fram": ["a", "b"]}, {}, "mean key_frame"),
        ({"margin": [1, 2]}, {}, "margin is not a key of model"),
        ({"gap_offset_mm": [1, 2]}, {}, "has a distribution: uncertainty.gap_offset_mm"),
        ({"key_frame": ["skewed"]}, {}, "two or more values, all different"),
        ({"key_frame": ["skewed", "square"]}, {}, "must be 'skewed' or 'deck_edge', got 'square'"),
        ({"backfill_vs_mps": [150, -1]}, {}, "greater than or equal to 0, got -1"),
        (FRAMES, {"analysis": {"scheme": "paper"}}, "key_frame has no effect if analysis.scheme"),
        (SPEEDS, {"grid": SPEEDS}, "remove backfill_vs_mps, an axis of the grid"),
    ):
        with pytest.raises(InputError, match=message):
            parse_config({"uncertainty": {"alternatives": alternatives}} | sections)


def test_all_variants_of_a_bridge_have_the_drawn_model(tmp_path) -> None:
    motions = [wave(f"w{number}", number=number) for number in (1, 2, 3, 4)]
    random = replace(ALTERNATING, incidence_deg=ANY_DIRECTION)
    draws = random.draws([each.motion.motion_id for each in motions])
    setup = study_of(tmp_path, *motions, bridges=("bridge_a", "osb1"), draws=draws)
    slugs = ("bridge_a_cf_skew60_gap051_mu050", "osb1_cf_skew00_gap025_mu000")
    springs, fixed = map(setup.tasks, slugs)
    for one, other, draw in zip(springs, fixed, draws.values(), strict=True):
        assert [getattr(one.options, name) for name in VALUES] == [draw[name] for name in VALUES]
        # the columns of osb1 have no foundation springs
        assert "foundation" not in other.draw
        assert (other.options.foundation, other.options.key_frame) == ("springs", draw["key_frame"])
        assert one.options == with_draw(ModelOptions(), draw)
        assert other.options.pad_strength_factor == draw["pad_strength_factor"]
        assert one.incidence_deg == other.incidence_deg == draw[random_properties.DIRECTION]
        row = row_of(one)
        assert {name: row[f"draw_{name}"] for name in NAMES} == {name: draw[name] for name in NAMES}
        assert run_key(setup.task_of(row)) == run_key(one)
    columns = [column.name for column in columns_with(row)]
    assert columns[-1] == "run_key"
    assert random_properties.drawn_properties(columns)[0] == "concrete strength"
    paths = [tmp_path / f"{slug}.parquet" for slug in slugs]
    for path, tasks in zip(paths, (springs, fixed), strict=True):
        write_variant([row_of(task) for task in tasks], path)
    join_variants(paths, tmp_path / "demands.parquet")
    table = read_frame(tmp_path / "demands.parquet").set_index("motion_id")
    of_springs = table[table["bridge"] == "bridge_a"]["choice_foundation"]
    assert of_springs.to_dict() == {name: draw["foundation"] for name, draw in draws.items()}
    assert table[table["bridge"] == "osb1"]["choice_foundation"].isna().all()
    assert set(table["choice_backfill_vs_mps"]) <= {"50", "150", "500"}
    # modelling choices are compared with the configured model
    (usual, *_) = setup.without_alternatives.tasks(slugs[0])
    frame = next(each for each in modelling_choices.CHOICES if each.key == "key_frame")
    assert frame.configured_in(usual) == "deck_edge"
    assert usual.options.pad_strength_factor == draws["w1"]["pad_strength_factor"]


def demands(motions: int, noise: float = 0.0) -> pd.DataFrame:
    rng, rows = np.random.default_rng(48), []
    draws = ALTERNATING.draws([f"m{number}" for number in range(motions)])
    scatter = noise * rng.normal(size=motions)
    for number, (motion, draw) in enumerate(draws.items()):
        for skew, gap in product((0, 60), (25, 51)):
            effect = log(0.88) + scatter[number]
            effect += log(1.06) * {"deck_edge": 1.0, "skewed": -1.0}[draw["key_frame"]]
            drift = exp(0.3 * number + 0.02 * (gap == 51) + (effect if skew else 0.0))
            columns = {f"choice_{name}": str(draw[name]) for name in VALUES}
            columns |= {"skew_deg": skew, "gap_mm": gap, "variant": f"{skew}{gap}"}
            rows.append(columns | {"motion_id": motion, "column_drift_ratio": drift})
    place = {"bridge": "b", "abutment": "contact_friction", "friction": 0.0, "scale": 1.0}
    return pd.DataFrame(rows).assign(**place, incidence_deg=0.0, status="ok", complete=True)


def test_effects_under_each_value_are_those_of_the_regression() -> None:
    exact = alternative_effects(demands(24)).set_index(["axis", "option", "value"]).sort_index()
    skew = exact["effect"]["skew_deg"]
    assert skew["key_frame", "deck_edge"] == pytest.approx(0.88 * 1.06)
    assert skew["key_frame", "skewed"] == pytest.approx(0.88 / 1.06)
    assert skew.drop("key_frame").to_numpy() == pytest.approx(0.88)
    assert exact["effect"]["gap_mm"].to_numpy() == pytest.approx(exp(0.02))
    # ordinary least squares of the motions with sum-coded columns, and without each motion
    runs = demands(24, noise=0.05)
    found = alternative_effects(runs).set_index(["axis", "option", "value"]).loc["skew_deg"]
    assert found["demand"].unique().tolist() == ["column_drift_ratio"]
    logs = runs.assign(y=np.log(runs["column_drift_ratio"]))
    change = logs.pivot_table(index="motion_id", columns="skew_deg", values="y").diff(axis=1)[60]
    of_motion = runs.drop_duplicates("motion_id").set_index("motion_id").loc[change.index]
    coded = [np.ones(24)]
    for option, levels in VALUES.items():
        names = sorted(map(str, levels))
        drawn = of_motion[f"choice_{option}"]
        coded += [1.0 * (drawn == each) - (drawn == names[-1]) for each in names[:-1]]
    design = np.column_stack(coded)
    rows = [np.arange(24), *(np.delete(np.arange(24), out) for out in range(24))]
    fits = [np.linalg.lstsq(design[own], change.to_numpy()[own])[0] for own in rows]
    first = np.array(fits)[:, 1]
    error = np.sqrt(np.sum((first[1:] - first[0]) ** 2) * 23 / 24)
    row = found.loc[("key_frame", "deck_edge")]
    assert log(row["ratio"]) == pytest.approx(first[0], abs=1e-9)
    half = log(row["ci_high"] / row["ci_low"]) / 2.0
    assert half == pytest.approx(1.734 * error, rel=0.01)  # t(0.95) of 24 - 5 to 24 - 7 dof
    residual = change.to_numpy() - design @ fits[0]
    share = 1.0 - (residual @ residual / (24 - 5)) / np.var(change.to_numpy(), ddof=1)
    assert found["share"].to_numpy() == pytest.approx(share, abs=1e-9)
    assert share > 0.4
    assert row["n_motions"] == (of_motion["choice_key_frame"] == "deck_edge").sum()


def test_the_page_names_the_options_that_move_an_effect() -> None:
    (certain, sizes), rows = alternative_rows(alternative_effects(demands(32, noise=0.05)))
    skew = next(row for row in rows if row["effect"].startswith("Skew"))
    assert sizes.startswith(f"{skew['effect']}: ")
    assert f"{skew['key frame skewed']} with key frame skewed" in sizes
    assert re.search(r"would be (\d+) to (\d+) % narrower", certain)
    # too few motions for seven coefficients, or no drawn options: no rows and no sentence
    for runs in (demands(8), demands(32).filter(regex="^(?!choice)")):
        assert alternative_effects(runs).empty
        assert alternative_rows(alternative_effects(runs)) == ([], [])


def test_values_have_the_same_text_as_numbers_and_in_tables() -> None:
    for option, value, text in (
        ("backfill_vs_mps", 50.0, "50 m/s"), ("wall_mass", True, "yes"),
        ("wall_restoring_n_per_m", 3.0e4, "0.03 MN/m"), ("key_frame", "deck_edge", "deck edge"),
    ):  # fmt: skip
        assert choice_text(option, value) == choice_text(option, f"{value}") == text
    assert choice_text("integrator", ("HHT", 0.7)) == "HHT 0.7"


def test_statistics_of_a_table_keep_its_options_that_act(tmp_path, monkeypatch):
    runs = demands(24, noise=0.05).assign(choice_foundation=None)
    runs["im_saavg_rotd50_g"] = np.exp(0.05 * runs["motion_id"].str[1:].astype(float) - 1.0)
    write_frame(runs, tmp_path / "demands.parquet", {})
    read: list[str] = []
    monkeypatch.setattr(tables, "read_frame", lambda p: read.append(p.name) or read_frame(p))
    statistics_of(tmp_path / "demands.parquet", tmp_path / "out", ROOT / "config/limit_states.yaml")
    assert read == ["demands.parquet"]  # once
    table = read_frame(tmp_path / "out/fragility/alternatives.parquet")
    assert table["option"].unique().tolist() == ["key_frame", "backfill_vs_mps"]
    assert table["effect"].to_numpy() == pytest.approx(alternative_effects(runs)["effect"])
    drawn = runs.assign(draw_deck_mass_factor=1.0)  # not of a script
    script, both = [load_structure(ROOT / "docs/own_bridge.py")], drawn.assign(draw_gap_offset_mm=1)
    for table, words in ((both, "(joint gap). It also"), (drawn, "is random. Each motion")):
        text = f"{words} has its own modelling options (key frame, "
        assert text in properties_sentence(table, script)

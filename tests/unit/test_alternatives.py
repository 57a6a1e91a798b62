"""Alternative modelling options: one draw per motion, and the effects under each value."""

import re
from dataclasses import replace
from itertools import product
from math import exp, log

import numpy as np
import pandas as pd
import pytest
from reference_pages import ROOT

from skewbridge.demands.columns import choice_text
from skewbridge.demands.tables import join_variants, write_variant
from skewbridge.errors import InputError
from skewbridge.files import tables
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.fragility.alternatives import alternative_effects
from skewbridge.report.answer import alternative_rows, properties_sentence
from skewbridge.report.methods import methods_of
from skewbridge.study.config import parse_config
from skewbridge.study.modelling_choices import CHOICES
from skewbridge.study.results import statistics_of
from skewbridge.study.task import run_key
from skewbridge.variant.random_properties import UncertaintyConfig
from study_parts import row_of, study_of, wave

VALUES = {
    "key_frame": ("deck_edge", "skewed"),
    "foundation": ("springs", "fixed"),
    "backfill_vs_mps": (50.0, 150.0, 500.0),
}
ON = UncertaintyConfig(enabled=True, alternatives=VALUES)
IDS = [f"m{number}" for number in range(32)]
FRAMES, SPEEDS = {"key_frame": ["skewed", "deck_edge"]}, {"backfill_vs_mps": [50, 150]}


def test_values_are_drawn_equally_often_and_change_no_property() -> None:
    draws = ON.draws(IDS)
    for name, values in VALUES.items():
        drawn = [draw[name] for draw in draws.values()]
        counts = np.array([[block.count(v) for v in values] for block in (drawn[:16], drawn[16:])])
        assert (counts.sum(axis=1) == 16).all()
        assert (np.ptp(counts, axis=1) <= 1).all(), name
    plain = replace(ON, alternatives={}).draws(IDS)
    for motion, draw in draws.items():
        assert {name: draw[name] for name in draw if name not in VALUES} == plain[motion]
    assert [*draws["m0"]][-3:] == [*VALUES]
    assert ON.draws(IDS[:3]) == {name: draws[name] for name in IDS[:3]}
    assert replace(ON, enabled=False).draws(IDS) == {}
    other = replace(ON, seed=2).draws(IDS)
    assert any(other[name]["key_frame"] != draws[name]["key_frame"] for name in IDS)


@pytest.mark.parametrize(
    ("alternatives", "sections", "message"),
    [
        ({"key_fram": ["a", "b"]}, {}, "mean key_frame"),
        ({"seed": [1, 2]}, {}, "seed is not a key of model"),
        ({"pad_strength_factor": [1, 2]}, {}, "pad_strength_factor is not"),
        ({"key_frame": ["skewed"]}, {}, "two or more values, all different"),
        ({"key_frame": ["skewed", "square"]}, {}, "must be 'skewed' or 'deck_edge', got 'square'"),
        ({"backfill_vs_mps": [150, -1]}, {}, "greater than or equal to 0, got -1"),
        (FRAMES, {"analysis": {"scheme": "paper"}}, "key_frame has no effect if analysis.scheme"),
        (SPEEDS, {"grid": SPEEDS}, "remove backfill_vs_mps, an axis of the grid"),
    ],
)  # fmt: skip
def test_bad_alternatives_are_refused(alternatives, sections, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_config({"uncertainty": {"alternatives": alternatives}} | sections)


def test_all_variants_of_a_bridge_have_the_drawn_model(tmp_path) -> None:
    motions = [wave(f"w{number}", number=number) for number in (1, 2, 3, 4)]
    draws = ON.draws([each.motion.motion_id for each in motions])
    setup = study_of(tmp_path, *motions, bridges=("bridge_a", "osb1"), draws=draws)
    slugs = ("bridge_a_cf_skew60_gap051_mu050", "osb1_cf_skew00_gap025_mu000")
    springs, fixed = map(setup.tasks, slugs)
    for one, other, draw in zip(springs, fixed, draws.values(), strict=True):
        assert [getattr(one.options, name) for name in VALUES] == [draw[name] for name in VALUES]
        # the columns of osb1 have no foundation springs
        assert "foundation" not in other.draw
        expected = ("springs", draw["key_frame"])
        assert (other.options.foundation, other.options.key_frame) == expected
        factor = draw["pad_strength_factor"]
        assert one.options.pad_strength_factor == other.options.pad_strength_factor == factor
    found = setup.task_of(row_of(springs[0]))
    assert found is not None
    assert run_key(found) == run_key(springs[0])
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
    frame = next(each for each in CHOICES if each.key == "key_frame")
    assert frame.configured_in(usual) == "deck_edge"
    assert usual.options.pad_strength_factor == draws["w1"]["pad_strength_factor"]


def demands(motions: int, noise: float = 0.0) -> pd.DataFrame:
    """Demands whose effect of skew is -12 %, and 6 % less or more by the key frame."""
    rng, rows = np.random.default_rng(48), []
    draws = ON.draws([f"m{number}" for number in range(motions)])
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
    sentences, rows = alternative_rows(alternative_effects(demands(32, noise=0.05)))
    certain, sizes = sentences
    assert certain.endswith("These certainly move an effect:")
    assert "key frame, foundation and backfill vs" in certain
    assert sizes.startswith("Skew 0° to 60° on column drift ratio, b: ")
    skew = next(row for row in rows if row["effect"].startswith("Skew"))
    for value in ("deck edge", "skewed"):
        assert f"{skew[f'key frame {value}']} with key frame {value}" in sizes
    assert re.search(r"would be (\d+) to (\d+) % narrower", certain)
    (none,), _ = alternative_rows(alternative_effects(demands(32, noise=0.5)))
    assert none.endswith("None certainly moves an effect.")
    # too few motions for seven coefficients, or no drawn options: no rows and no sentence
    for runs in (demands(8), demands(32).filter(regex="^(?!choice)")):
        assert alternative_effects(runs).empty
        assert alternative_rows(alternative_effects(runs)) == ([], [])


def test_values_have_the_same_text_and_unit_in_all_places() -> None:
    texts = {("backfill_vs_mps", 50.0): "50 m/s", ("wall_mass", True): "yes",
             ("wall_restoring_n_per_m", 3.0e4): "0.03 MN/m",
             ("key_frame", "deck_edge"): "deck edge"}  # fmt: skip
    for (option, value), text in texts.items():
        # a table has texts of values
        assert choice_text(option, value) == choice_text(option, f"{value}") == text
    assert choice_text("integrator", ("HHT", 0.7)) == "HHT 0.7"
    methods = methods_of(parse_config({"uncertainty": {"enabled": True, "alternatives": VALUES}}))
    assert "Backfill vs: 50 m/s, 150 m/s and 500 m/s, equally" in " ".join(methods.parts.values())


def test_statistics_of_a_table_keep_its_options_but_one_that_does_not_act(
    tmp_path, monkeypatch
) -> None:
    runs = demands(24, noise=0.05).assign(choice_foundation=None)
    runs["im_saavg_rotd50_g"] = np.exp(0.05 * runs["motion_id"].str[1:].astype(float) - 1.0)
    write_frame(runs, tmp_path / "demands.parquet", {})
    read: list[str] = []
    monkeypatch.setattr(tables, "read_frame", lambda p: read.append(p.name) or read_frame(p))
    statistics_of(tmp_path / "demands.parquet", tmp_path / "out", ROOT / "config/limit_states.yaml")
    assert read == ["demands.parquet"]  # once
    table = read_frame(tmp_path / "out/fragility/alternatives.parquet")
    assert table["option"].unique().tolist() == ["key_frame", "backfill_vs_mps"]
    assert "its own modelling options (key frame, " in properties_sentence(runs)
    assert table["effect"].to_numpy() == pytest.approx(alternative_effects(runs)["effect"])

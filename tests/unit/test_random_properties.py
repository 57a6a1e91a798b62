"""Random properties: their distributions, one draw per motion in every variant, and the setting."""

from dataclasses import replace
from math import log

import numpy as np
import pandas as pd
import pytest
from scipy import special, stats

from skewbridge.bridge.backfill import Passive
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import core_concrete, steel_of
from skewbridge.bridge.structures import built_bridge
from skewbridge.demands.columns import columns_with
from skewbridge.report.answer import properties_sentence
from skewbridge.report.methods import REFERENCES, methods_of
from skewbridge.study.config import parse_config
from skewbridge.study.modelling_choices import CHOICES
from skewbridge.study.task import run_key
from skewbridge.variant import random_properties
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import RandomProperty, UncertaintyConfig, with_draw
from skewbridge.variant.variant import Variant
from study_parts import row_of, study_of, wave

ANY_DIRECTION = RandomProperty(distribution="uniform", low=0.0, high=360.0, source="test")
ON = UncertaintyConfig(enabled=True, incidence_deg=ANY_DIRECTION)
NAMES = list(ON.properties)
IDS = [f"m{number:04d}" for number in range(2000)]
SLUG = "osb1_cf_skew30_gap025_mu050"
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


DRAWS = ON.draws(IDS)


@pytest.mark.parametrize("name", NAMES)
def test_draws_have_their_distribution(name: str) -> None:
    values = np.array([draw[name] for draw in DRAWS.values()])
    what = ON.drawn[name]
    assert what.low <= values.min()
    assert values.max() <= what.high
    found = stats.kstest(values, np.vectorize(lambda value: expected(what, value)))
    assert found.pvalue > 0.01
    # draws that are off by a tenth of the range do not pass
    shifted = values + 0.1 * (what.high - what.low)
    assert stats.kstest(shifted, np.vectorize(lambda v: expected(what, v))).pvalue < 1e-6


def test_each_block_is_a_latin_hypercube() -> None:
    rows = np.array([list(draw.values()) for draw in DRAWS.values()])
    for start in (0, random_properties.BLOCK):
        block = rows[start : start + random_properties.BLOCK]
        for name, column in zip(NAMES, block.T, strict=True):
            shares = [expected(ON.drawn[name], value) for value in column]
            # six digits of a value are kept
            steps = np.floor(np.array(shares) * len(block) * (1.0 - 1e-9))
            assert sorted(steps) == list(range(len(block))), name
    assert np.abs(np.corrcoef(rows.T) - np.eye(len(NAMES))).max() < 0.08


def test_more_motions_and_fewer_properties_change_no_draw() -> None:
    few = ON.draws(IDS[:5])
    assert few == {name: DRAWS[name] for name in IDS[:5]}
    without = replace(ON, deck_mass_factor=None, gap_offset_mm=None).draws(IDS[:5])
    for name, draw in without.items():
        assert draw == {key: value for key, value in few[name].items() if key in draw}
        assert len(draw) == len(NAMES) - 2
    assert replace(ON, seed=2).draws(IDS[:5]) != few
    assert ON.draws(IDS[:5], suite="far") != few
    assert UncertaintyConfig().draws(IDS) == {}


def test_every_variant_has_the_draw_of_the_motion(tmp_path) -> None:
    motions = [wave(f"w{number}", number=number) for number in (1, 2, 3)]
    draws = ON.draws([each.motion.motion_id for each in motions])
    setup = study_of(tmp_path, *motions, draws=draws)
    slugs = ("osb1_cf_skew00_gap025_mu000", "osb1_cf_skew60_gap051_mu050")
    first, second = (setup.tasks(slug) for slug in slugs)
    for one, other, draw in zip(first, second, draws.values(), strict=True):
        assert one.options == other.options == with_draw(ModelOptions(), draw)
        assert one.incidence_deg == other.incidence_deg == draw[random_properties.DIRECTION]
        row = row_of(one)
        assert {name: row[f"draw_{name}"] for name in NAMES} == draw
        found = setup.task_of(row)
        assert found is not None
        assert run_key(found) == run_key(one)
    plain = study_of(tmp_path, *motions).tasks(slugs[0])
    assert len({run_key(task) for task in (*first, *plain)}) == 6
    columns = [column.name for column in columns_with(row)]
    assert set(columns) >= {f"draw_{name}" for name in NAMES}
    assert columns[-1] == "run_key"
    assert random_properties.drawn_properties(columns)[0] == "concrete strength"


def test_without_draws_a_bridge_is_that_of_its_file(tmp_path) -> None:
    for name in ("osb1", "osb1_fixed", "bridge_a", "osb2s"):
        assert built_bridge(load_bridge(name), ModelOptions()) == load_bridge(name)
    passive = Passive(stiffness_n_per_m=3.0e7, ultimate_n=4.0e6, failure_ratio=0.7)
    assert passive.scaled(1.0, 1.0) == passive
    (task,) = study_of(tmp_path).tasks(SLUG)
    assert task.options == ModelOptions()
    assert task.incidence_deg == 0.0
    assert not random_properties.drawn_properties(row_of(task))
    # a modelling choice keeps the draw of the motion
    choice = next(each for each in CHOICES if each.key == "pad_strength_factor")
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
    scaled = built_bridge(usual, options)
    before, after = usual.column, scaled.column
    assert after.elastic_modulus_gpa == pytest.approx(1.1 * before.elastic_modulus_gpa)
    assert steel_of(after).yield_pa == pytest.approx(1.1 * steel_of(before).yield_pa)
    assert core_concrete(after).peak_pa > 1.15 * core_concrete(before).peak_pa
    keys_kn = [each.abutment.sacrificial_key.force_kn[1] for each in (usual, scaled)]
    assert keys_kn[1] == pytest.approx(1.3 * keys_kn[0])
    weights_n = []
    for each in (ModelOptions(), options):
        with domain():
            model = build(Variant.at("osb1", "contact_friction", AT), each)
            weights_n.append(model.weight_n)
            gaps_m = [side.gap_m for side in model.abutments]
    assert 0.9 < weights_n[1] / weights_n[0] < 0.92  # columns keep their weight
    assert gaps_m == pytest.approx([0.020, 0.020])


# source: PyPBEE, commit 8b35e30, examples/Bridge_A/osb_info_Bridge_A.py: fpc, fy, xi, w, Fult, K50
VARIATIONS = {
    "concrete_strength_factor": "0.16", "steel_strength_factor": "0.04", "damping_factor": "0.5",
    "deck_mass_factor": "0.04", "backfill_strength_factor": "0.2",
    "backfill_stiffness_factor": "0.2",
}  # fmt: skip


def test_methods_and_page_state_the_setting_and_every_distribution_with_its_source() -> None:
    direction = {"distribution": "uniform", "low": 0.0, "high": 360.0, "source": "assumed"}
    off, on = (
        methods_of(parse_config({"uncertainty": {"enabled": enabled, "incidence_deg": direction}}))
        for enabled in (False, True)
    )
    assert "No property of a bridge is random" in off.parts["Random properties"]
    text = on.parts["Random properties"]
    assert "Deck mass: uniform, 0.9 to 1.1" in text
    assert "each from a random direction" in on.parts["Ground motions"]
    assert "memory" not in on.markdown()
    for key in ("Pan, Y.", "PyPBEE"):
        assert any(key in work for work in on.references)
    for name, what in UncertaintyConfig(enabled=True).drawn.items():
        assert f"{what.as_text} ({what.source})" in text
        if name in VARIATIONS:
            cited = f"; PyPBEE has a coefficient of variation of {VARIATIONS[name]}"
            assert what.source == f"assumed{cited}"
        else:
            assert what.source.startswith("assumed")
            assert not any(key in what.source for key in REFERENCES)
    assert "values of the bridge files" in properties_sentence(pd.DataFrame(columns=["variant"]))
    assert "(deck mass)" in properties_sentence(pd.DataFrame(columns=["draw_deck_mass_factor"]))

"""Paired effects at two accuracies: what is pooled, what is judged, what is not run again."""

from itertools import product

import pytest

from skewbridge.errors import InputError
from skewbridge.verification import registry
from skewbridge.verification.studies import accuracy
from skewbridge.verification.studies.accuracy import (
    ALL_PLACES,
    DEMANDS,
    SETS,
    AccuracySet,
    pooled_ratios,
    run_accuracy,
)
from skewbridge.verification.studies.comparison import Study

# two motions cut to 2 s of shaking beyond their tapers, friction alone, coarse against default
TINY = AccuracySet(
    skews_deg=(0,),
    gaps_mm=(25,),
    motion_count=2,
    window_s=2.1,
    judged="fast",
    exact="default",
    processes=1,
)


def made_up(chosen, motions, ratios):
    """Return peaks that grow by a ratio per motion and accuracy wherever there is friction."""
    return {
        (accuracy, variant, motion): dict.fromkeys(
            DEMANDS, ratios[accuracy, motion] if variant.friction_pct else 1.0
        )
        for accuracy, variant, motion in product(
            (chosen.judged, chosen.exact), chosen.variants(), motions
        )
    }


def test_the_whole_set_pairs_neighbours_on_every_axis():
    chosen = SETS["accuracy"]
    pairs = chosen.pairs()
    assert len(chosen.variants()) == 12
    assert {axis: sum(name == axis for name, *_ in pairs) for axis, *_ in pairs} == {
        "friction_pct": 6,
        "gap_mm": 6,
        "skew_deg": 8,
    }
    for axis, before, after in pairs:
        same = {"friction_pct", "gap_mm", "skew_deg"} - {axis}
        assert all(getattr(before, name) == getattr(after, name) for name in same)
        assert getattr(after, axis) > getattr(before, axis)


def test_ratios_are_geometric_means_over_motions_and_over_places():
    chosen = AccuracySet(skews_deg=(0, 30))
    ratios = {
        ("default", "a"): 1.2,
        ("default", "b"): 0.9,
        ("reference", "a"): 1.1,
        ("reference", "b"): 0.9,
    }
    table = pooled_ratios(chosen, made_up(chosen, ("a", "b"), ratios), ("a", "b"))
    friction = table[table["axis"] == "friction_pct"]
    assert len(friction) == len(DEMANDS) * (4 + 1)
    assert set(friction.loc[friction["place"] == ALL_PLACES, "count"]) == {8}
    assert friction["ratio"].to_numpy() == pytest.approx((1.2 * 0.9) ** 0.5)
    assert friction["exact_ratio"].to_numpy() == pytest.approx((1.1 * 0.9) ** 0.5)
    difference = 100 * ((1.2 / 1.1) ** 0.5 - 1)
    assert friction["difference_percent"].to_numpy() == pytest.approx(difference)
    others = table[table["axis"] != "friction_pct"]
    assert others["ratio"].to_numpy() == pytest.approx(1.0)


def test_a_motion_without_the_demand_is_left_out_of_both():
    chosen = AccuracySet(skews_deg=(0,), gaps_mm=(25,))
    ratios = dict.fromkeys(product(("default", "reference"), ("a", "b")), 1.5)
    found = made_up(chosen, ("a", "b"), ratios)
    found["reference", chosen.variants()[0], "b"]["unseating_m"] = 0.0
    table = pooled_ratios(chosen, found, ("a", "b")).query(f"place == '{ALL_PLACES}'")
    assert table.set_index("demand")["count"].to_dict() == {
        demand: 1 if demand == "unseating_m" else 2 for demand in DEMANDS
    }


def test_finished_analyses_are_not_repeated(tmp_path, monkeypatch):
    first = Study("accuracy", tmp_path)
    run_accuracy(first, TINY)
    table = first.tables["ratios"]
    assert len(table) == 2 * len(DEMANDS)  # one place, and all of them
    assert set(table["count"]) == {2}
    kept = (tmp_path / "accuracy.jsonl").read_text()
    assert kept.count('"key"') == 8
    summary, failed = first.comparisons[-2:]
    assert summary.value == pytest.approx(table["difference_percent"].abs().max())
    assert "largest difference of 8 pooled ratios" in summary.quantity
    assert failed.value == 0.0

    calls = []
    plain = accuracy.analyse
    # a kill cut the last line short: that analysis alone runs again
    (tmp_path / "accuracy.jsonl").write_text(kept.rstrip()[:-20])
    monkeypatch.setattr(accuracy, "analyse", Counted(calls, plain), raising=True)
    second = Study("accuracy", tmp_path)
    run_accuracy(second, TINY)
    assert len(calls) == 1
    assert second.tables["ratios"].equals(table)
    assert second.comparisons == first.comparisons


class Counted:
    """A function that notes each call of it."""

    def __init__(self, calls, function):
        self.calls, self.function = calls, function
        self.__module__ = function.__module__

    def __call__(self, *args):
        self.calls.append(args)
        return self.function(*args)


def test_long_studies_run_only_when_named(monkeypatch, tmp_path):
    ran = []

    def run(name, kept, _tell):
        ran.append((name, kept))
        return Study(name, kept)

    monkeypatch.setattr(registry, "run_study", run)
    registry.run_studies([], tmp_path)
    assert [name for name, _ in ran] == list(registry.STUDIES)
    registry.run_studies(["accuracy"], tmp_path)
    assert ran[-1] == ("accuracy", tmp_path)
    with pytest.raises(InputError, match="accuracy-whole"):
        registry.run_studies(["nothing"], tmp_path)

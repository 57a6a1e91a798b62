"""Selection of the analyses of the next round, its plan and its demands."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from skewbridge.errors import InputError
from skewbridge.fragility.effects import effect_table
from skewbridge.fragility.sequential import rounds_table
from skewbridge.report.effect_figures import widths_by_analyses
from skewbridge.study.config import DesignConfig, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.rounds import limit_of_round, round_line, setup_of_round, tables_of_round
from skewbridge.study.selection import first_motions, next_motions, targets
from study_parts import study_of, wave

LOOKS = DesignConfig().looks
PLACES = pd.DataFrame(
    {"bridge": "b", "abutment": "a", "gap_mm": [25.0, 51.0] * 2, "friction": [0.0, 0.0, 0.5, 0.5]},
    index=["g25", "g51", "g25f", "g51f"],
)
EVEN = dict.fromkeys(PLACES.index, 12)


def cell(demand: str, ratio: float, scatter: tuple[float, float], motions: int = 12) -> list[dict]:
    """Return the rows of an effect of friction: pooled, and of its two pairs of variants."""
    shared = {"bridge": "b", "abutment": "a", "quantity": "demand", "demand": demand}
    shared |= {"axis": "friction", "from_value": 0.0, "to_value": 0.5, "margin": 0.05}
    shared |= {"level": 0.98, "n_discordant": 0, "n_pairs": motions, "dof": motions - 1}
    rows = []
    for sd, place in (
        (float(np.hypot(*scatter)) / 2.0, {"scope": "pooled"}),
        (scatter[0], {"scope": "variant", "gap_mm": 25.0}),
        (scatter[1], {"scope": "variant", "gap_mm": 51.0}),
    ):
        half = 2.7 * sd / np.sqrt(motions)
        ends = {"ci_low": ratio * np.exp(-half), "ci_high": ratio * np.exp(half)}
        rows.append(shared | {"ratio": ratio, "scatter": sd} | ends | place)
    return rows


def asked(*rows: dict, cost: dict[str, float] | None = None) -> tuple[pd.DataFrame, list[dict]]:
    table = effect_table(PLACES, [row for part in rows for row in part])
    return targets(table, EVEN, cost or dict.fromkeys(EVEN, 1.0), PLACES, LOOKS, 0.90)


def test_only_open_cells_within_reach_ask_for_motions() -> None:
    decided, near, far = (
        cell("deck_disp_m", 1.0, (0.02, 0.02)),
        cell("column_drift_ratio", 1.0, (0.12, 0.12)),
        cell("unseating_m", 1.0, (1.5, 1.5)),
    )
    table, wanted = asked(decided, near, far)
    assert table["asked"].tolist() == [False, True, False]
    assert not wanted[0]
    assert not wanted[2]
    assert 12 < min(wanted[1].values()) <= max(wanted[1].values()) <= 64
    assert table["needed"].iloc[2] > 64


def test_pairs_that_scatter_more_get_more_motions() -> None:
    _, (wanted,) = asked(cell("column_drift_ratio", 1.0, (0.06, 0.12)))
    assert wanted["g51"] == wanted["g51f"]
    assert wanted["g51"] / wanted["g25"] == pytest.approx(2.0, rel=0.1)


def test_pairs_with_long_analyses_get_fewer_motions() -> None:
    cost = dict(zip(EVEN, (1.0, 4.0, 1.0, 4.0), strict=True))
    _, (wanted,) = asked(cell("column_drift_ratio", 1.0, (0.1, 0.1)), cost=cost)
    assert wanted["g25"] / wanted["g51"] == pytest.approx(2.0, rel=0.1)


def test_a_round_has_the_cheapest_decisions_that_fit_into_the_time() -> None:
    cost = dict.fromkeys(EVEN, 10.0)
    wanted = [{"g25": 40, "g25f": 40}, {"g51": 20, "g51f": 20}, {}]
    both = next_motions(wanted, EVEN, cost, LOOKS, 200.0)
    assert both == dict.fromkeys(EVEN, 16)
    assert next_motions(wanted, EVEN, cost, LOOKS, 100.0) == EVEN | {"g51": 16, "g51f": 16}
    assert next_motions(wanted, EVEN, cost, LOOKS, 50.0) == EVEN


def test_the_first_round_is_shorter_where_the_time_is_short() -> None:
    none, cost = dict.fromkeys(EVEN, 0), dict.fromkeys(EVEN, 10.0)
    assert first_motions(none, cost, 12, 1e6) == EVEN
    assert first_motions(none, cost, 12, 130.0) == dict.fromkeys(EVEN, 3)
    assert first_motions(none, cost, 12, -1.0) == none
    assert first_motions(dict.fromkeys(EVEN, 3), cost, 12, 90.0) == dict.fromkeys(EVEN, 5)


def plan(ended: str | None, **changes: object) -> dict[str, object]:
    content = {"round": 3, "ended": ended, "hours": 2.0, "analyses": 48, "forecast_s": 170.0}
    content |= {"motions": {"a": [12, 16], "b": [12, 12]}, "decided": 19, "cells": [{}] * 24}
    return content | changes


def test_each_round_has_one_line() -> None:
    start = "round 3: 19 of 24 decided; "
    assert round_line(plan(None)) == f"{start}next 48 analyses, about 3 min"
    assert round_line(plan("decided")) == f"{start}the question is answered"
    assert "5 are out of reach" in round_line(plan("most"))
    assert "a larger value resumes" in round_line(plan("hours"))
    assert round_line(plan(None, cells=[])) == "round 3: next 48 analyses, about 3 min"


def test_a_plan_names_the_demands_of_its_round_and_the_motions_of_a_variant(
    tmp_path: Path,
) -> None:
    folder = StudyFolder(tmp_path)
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(plan(None)))
    assert tables_of_round(folder, path) == [folder.round_demands(3, "a")]
    setup = study_of(tmp_path, *(wave(f"m{n}", duration_s=1.0, number=n) for n in range(1, 6)))
    path.write_text(json.dumps(plan(None, motions={"a": [1, 3]})))
    chosen = setup_of_round(setup, path, "a").suite
    assert [each.motion.motion_id for each in chosen] == ["m2", "m3"]


@pytest.mark.parametrize(
    ("ended", "hours", "limit"),
    [("hours", 3.0, 3.0), ("hours", 1.0, 2.0), ("most", 9.0, 2.0), (None, 9.0, 2.0)],
)
def test_only_a_plan_that_time_ended_is_made_again_with_more(
    tmp_path: Path, ended: str | None, hours: float, limit: float
) -> None:
    path = tmp_path / "plan.json"
    assert limit_of_round(path, hours) == hours
    path.write_text(json.dumps(plan(ended)))
    assert limit_of_round(path, hours) == limit


def test_a_study_in_rounds_prepares_the_largest_number_of_motions() -> None:
    assert parse_config({"design": {"until": "decided"}}).motions.count == 64
    chosen = {"design": {"until": "decided", "most": 40}, "motions": {"count": 32}}
    assert parse_config(chosen).motions.count == 40
    assert parse_config({"design": {"most": 40}}).motions.count == 32
    with pytest.raises(InputError, match="an IDA has no rounds"):
        parse_config({"design": {"until": "decided"}, "motions": {"design": "ida"}})
    with pytest.raises(InputError, match="first must be below most"):
        parse_config({"design": {"first": 64}})


def test_cells_of_all_rounds_are_one_table_and_one_figure() -> None:
    rows = [row for row in cell("deck_disp_m", 1.0, (0.02, 0.02)) if row["scope"] == "pooled"]
    first = {"verdict": "undecided", "n_motions": 12, "needed": 30.0, "asked": True}
    first |= dict.fromkeys(("difference", "difference_low", "difference_high"))
    plans = [
        plan(None, round=1, analyses_before=0, cells=[]),
        plan(None, round=2, analyses_before=48, cells=[rows[0] | first]),
        plan("decided", analyses_before=64, cells=[rows[0] | first | {"verdict": "negligible"}]),
    ]
    table = rounds_table(plans)
    assert table[["round", "analyses", "verdict"]].to_numpy().tolist() == [
        [1, 48, "undecided"],
        [2, 64, "negligible"],
    ]
    dots = [
        line.get_xdata().tolist()
        for line in widths_by_analyses(table).axes[0].lines
        if line.get_marker() == "o"
    ]
    assert dots == [[64]]
    assert rounds_table(plans[:1]).empty

"""Trial runs of a study: their corners, what is in reach, the levels they propose."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from motions_files import make_pairs
from skewbridge.cli import build_app
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.errors import InputError
from skewbridge.study import analyses
from skewbridge.study.batch import row_of_task
from skewbridge.study.config import parse_config
from skewbridge.study.task import Task, no_result, run_key
from skewbridge.study.trial_runs import Strengths, corner_variants, propose, run_trials
from skewbridge.variant.variant import parse_slug

IM = "im_saavg_rotd50_g"
STRENGTHS = Strengths(level_g=np.full(16, 0.4), measures={"osb1": [{IM: 0.4}] * 16})


def curves(thetas_g: Sequence[float], **columns: object) -> pd.DataFrame:
    """Lines of demands in whose cloud these are the medians, with a dispersion of 0.3."""
    return pd.DataFrame(
        {
            "variant": "v", "bridge": "osb1", "component": "c", "method": "cloud", "im": IM,
            "limit_state": [f"s{n}" for n in range(len(thetas_g))], "threshold": 1.0,
            "ln_a": -np.log(thetas_g), "b": 1.0, "sigma": 0.3, "warnings": "", "n_exceed": 0,
            "n_unknown": 0,
        }
        | columns
    )  # fmt: skip


def test_no_two_axes_change_together_from_corner_to_corner() -> None:
    grid = {"skew_deg": [0, 30, 60], "gap_mm": [25, 38, 51], "friction": [0.0, 0.2, 0.5]}
    corners = [parse_slug(slug) for slug in corner_variants(parse_config({"grid": grid}).grid)]
    assert len(corners) == 8
    own = [each for each in corners if each.bridge == "osb1"]
    axes = [[each.skew_deg == 60, each.gap_mm == 51, each.friction_pct == 50] for each in own]
    signs = 2 * np.array(axes, dtype=int) - 1
    np.testing.assert_array_equal(signs.T @ signs, 4 * np.eye(3))


def test_a_corner_of_a_roller_is_there_once() -> None:
    grid = {"bridge": ["osb1"], "abutment": ["roller"]}
    assert len(corner_variants(parse_config({"grid": grid}).grid)) == 2


def test_levels_go_up_where_the_medians_are() -> None:
    found = propose(curves([0.9, 1.2, 1.4, 1.6]), STRENGTHS, (0.1, 1.0))
    assert found.in_reach == 3  # beyond 1.5 times the strongest level a line is not followed
    assert found.level_range_g[1] == 1.5
    assert found.share > found.configured_share + 0.3


def test_levels_that_are_as_good_stay() -> None:
    found = propose(curves([0.3, 0.4, 0.5]), STRENGTHS, (0.1, 1.5))
    assert found.level_range_g == found.configured_g == (0.1, 1.5)
    assert found.share == found.configured_share > 0.99


def test_no_factor_is_beyond_its_limits() -> None:
    """At 0.3 g of their own the motions reach 1.2 g."""
    weak = Strengths(level_g=np.full(16, 0.3), measures={"osb1": [{IM: 0.3}] * 16})
    found = propose(curves([1.1, 1.2, 1.3]), weak, (0.1, 1.0))
    assert found.level_range_g[1] <= 1.25


@pytest.mark.parametrize(
    "columns", [{"warnings": ["", "saturating"]}, {"n_unknown": [0, 1]}, {"b": [1.0, -1.0]}]
)
def test_unreachable_states_move_no_level(columns: dict[str, object]) -> None:
    found = propose(curves([0.4, 1.4], **columns), STRENGTHS, (0.1, 1.0))
    assert (found.in_reach, found.n_states) == (1, 2)
    assert found.level_range_g == (0.1, 1.0)


def test_the_forecast_is_the_probability_of_two_on_both_sides() -> None:
    """Two coins that are thrown 16 times: 1 - 2 (1 + 16)/2^16."""
    found = propose(curves([0.4], sigma=1.0e6), STRENGTHS, (0.1, 1.0))
    assert found.share == pytest.approx(1.0 - 2.0 * 17.0 / 2.0**16, abs=1e-5)


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Keys of what was analysed; demands grow with the intensity, by motion more or less."""
    keys: list[str] = []

    def fake(tasks: Sequence[Task], journal: Any, done: Any, **_: object) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = []
        for number, task in enumerate(tasks):
            key = run_key(task)
            level = task.motion.measures[IM] * (1.0 + 0.2 * (number % 3))
            demands = {column.name: 0.05 * level for column in DEMAND_COLUMNS}
            outcome = no_result("ok", "") | demands | {"wall_s": 1.0, "cpu_s": 1.0}
            rows.append(done[key] if key in done else row_of_task(outcome, task, key))
            if key not in done:
                keys.append(key)
                journal.append(rows[-1])
        return rows

    monkeypatch.setattr(analyses, "run_tasks", fake)
    return keys


@pytest.fixture
def config(tmp_path: Path) -> Path:
    folder = tmp_path / "motions"
    folder.mkdir()
    make_pairs(folder, 8)
    path = tmp_path / "study.yaml"
    path.write_text(
        f"results: {tmp_path / 'results'}\n"
        "grid: {bridge: [osb1], gap_mm: [51]}\n"
        f"motions: {{folder: {folder}, count: 8}}\n"
    )
    return path


def test_the_command_prints_lines_to_paste_and_repeats_no_analysis(
    config: Path, ran: list[str]
) -> None:
    arguments = ["plan", "--config", str(config), "--pilot", "4"]
    first = CliRunner().invoke(build_app(), arguments)
    assert first.exit_code == 0, first.output
    assert "motions:\n  level_range_g: [" in first.stderr
    assert len(ran) == len(set(ran)) == 16
    again = CliRunner().invoke(build_app(), [*arguments, "--json"])
    assert again.exit_code == 0, again.output
    assert len(ran) == 16
    study = config.parent / "results"
    assert (study / "journal/trial_runs.jsonl").exists()
    assert not (study / "motions").exists(), "the suite of the study is not that of its pilot"


def test_a_pilot_asks_for_levels_and_motions(config: Path, ran: list[str]) -> None:
    raw = {"results": str(config.parent / "results"), "motions": {"design": "stripes"}}
    with pytest.raises(InputError, match="not of stripes"):
        run_trials(parse_config(raw), 8)
    result = CliRunner().invoke(build_app(), ["plan", "--config", str(config), "--pilot", "9"])
    assert result.exit_code == 2
    assert "got 9" in result.stderr
    assert ran == []

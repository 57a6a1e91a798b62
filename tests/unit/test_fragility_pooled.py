"""Pooled effects, cells drawn towards them, several models in one table, motions still needed."""

import json
from pathlib import Path

from typer.testing import CliRunner

from fragility_tables import paired_effects, synthetic_demands
from skewbridge.cli import build_app
from skewbridge.files.tables import write_frame
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.verdicts import needed_motions

STATES = load_limit_states(Path(__file__).parents[2] / "config" / "limit_states.yaml")
MODEL = ["bridge", "abutment"]


def test_plan_says_how_many_motions_would_decide(tmp_path):
    table = synthetic_demands(motions=12, run_scatter=0.1).assign(cpu_s=4.0)
    needed = needed_motions(paired_effects(table), table)
    results = tmp_path / "results"
    write_frame(needed, results / "fragility" / "needed_motions.parquet", {})
    config = tmp_path / "config.yaml"
    config.write_text(f"results: {results}\n")
    run = CliRunner().invoke(build_app(), ["plan", "--config", str(config), "--json"])
    assert run.exit_code == 0
    said = json.loads(run.stdout)["needed_motions"]
    assert len(said) == len(needed) > 0
    assert set(said[0]) == set(needed.columns)
    shown = CliRunner().invoke(build_app(), ["plan", "--config", str(config)])
    assert "Motions that decide the pooled effects" in shown.stdout

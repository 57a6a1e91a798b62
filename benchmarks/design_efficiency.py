"""Half-widths of effects of osb1 in designs with equal numbers of analyses.

Designs of 288 analyses: `full`, 24 of 48 recorded pairs in one orientation and all twelve variants;
`blocks`, the default study without its complete motions: 48 pairs in both orientations, all skews
and one cell of gap and friction each; `spread`, such blocks with levels over the whole range
instead of bands. `full` and `blocks` are means over random parts of larger runs: FULL has all pairs
in one orientation and all variants, DEFAULT is the default study. `all` and `default` are these
runs.

Usage: design_efficiency.py FULL.parquet DEFAULT.parquet SPREAD.parquet
"""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd

from skewbridge.fragility import demand_table
from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.effects import effect_tables, median_effects
from skewbridge.fragility.limit_states import (
    HEADLINE_STATES,
    load_limit_states,
    with_column_failure,
)
from skewbridge.fragility.settings import DEFAULTS

DEMANDS = ("deck_disp_m", "column_drift_ratio", "column_shear_dcr", "unseating_m")
DRAWS = 4
CELL = ["gap_mm", "friction"]


def half_of_the_motions(table, rng):
    """Return the runs of half of the motions."""
    motions = table["motion_id"].drop_duplicates().to_numpy()
    return table[table["motion_id"].isin(rng.permutation(motions)[: motions.size // 2])]


def one_cell(table, rng):
    """Return the runs of each motion and orientation in one cell of gap and friction."""
    cell = table[CELL].astype(str).agg("/".join, axis=1)
    chosen = cell.groupby([table["motion_id"], table["incidence_deg"]]).transform(
        lambda cells: rng.choice(np.unique(cells))
    )
    return table[cell == chosen]


def half_widths(table, states):
    """Return the half-width of ln ratio of the pooled effects of largest values, by effect."""
    wanted = [state.demand for state in states]
    checked = demand_table.prepared(table.reset_index(drop=True), [*wanted, *DEMANDS], DEFAULTS)
    models = fit_models(checked.table, states, DEFAULTS)
    tables = [
        median_effects(checked.table, states, DEFAULTS, models=models),
        effect_tables(checked.table, DEMANDS, DEFAULTS).effects,
    ]
    pooled = pd.concat([part[part["scope"] == "pooled"] for part in tables])
    last = pooled.groupby("axis")["to_value"].transform("max") == pooled["to_value"]
    pooled = pooled[last & pooled["demand"].isin([*HEADLINE_STATES, *DEMANDS])]
    width = 0.5 * np.log(pooled["ci_high"] / pooled["ci_low"])
    return dict(zip(pooled["axis"] + " " + pooled["demand"], width, strict=True))


def main(full_run, default_study, spread_run):
    """Return the mean half-widths over draws of each design, and their ratios."""
    table, default, spread = map(pd.read_parquet, (full_run, default_study, spread_run))
    default = default[default["bridge"] == "osb1"]
    limits = Path(__file__).parents[1] / "config" / "limit_states.yaml"
    states = [
        state
        for state in with_column_failure(load_limit_states(limits), table.columns)
        if state.key in HEADLINE_STATES or state.component == "column_failure"
    ]
    rng = np.random.default_rng(45)
    found, sizes = {}, {}
    for name, design, source, draws in (
        ("all", None, table, 1),
        ("default", None, default, 1),
        ("full", half_of_the_motions, table, DRAWS),
        ("blocks", one_cell, default, DRAWS),
        ("spread", None, spread, 1),
    ):
        samples = [design(source, rng) if design else source for _ in range(draws)]
        sizes[name] = len(samples[0])
        widths = pd.DataFrame([half_widths(sample, states) for sample in samples])
        found[name] = widths.mean()
        found[f"{name}_without"] = widths.isna().sum()  # draws without an interval
    rows = pd.DataFrame(found)
    rows["blocks_over_full"] = rows["blocks"] / rows["full"]
    rows["bands_over_spread"] = rows["blocks"] / rows["spread"]
    effects = rows.round(4).replace({np.nan: None}).to_dict("index")
    return {"analyses": sizes, "draws": DRAWS, "half_widths": effects}


if __name__ == "__main__":
    text = json.dumps(main(*sys.argv[1:4]), indent=1)
    Path(__file__).with_suffix(".json").write_text(text + "\n", encoding="utf-8")

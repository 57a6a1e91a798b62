"""Half-widths of effects in designs with equal numbers of analyses, from one full run.

The full run has 48 recorded pairs, both orientations and all twelve variants of osb1, at levels in
bands. Sub-samples of 288 analyses: 24 pairs in one orientation and all variants (`full`), or 48
pairs in both orientations, all skews and one cell of gap and friction each (`blocks`); and blocks
with every sixth pair in all cells, which have more analyses (`default`). A second run has these
blocks at levels spread over the range of the earlier studies.

Usage: design_efficiency.py FULL.parquet SPREAD.parquet
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
from skewbridge.motions.blocks import assign
from skewbridge.motions.levels import BlocksConfig

DEMANDS = ("deck_disp_m", "column_drift_ratio", "column_shear_dcr", "unseating_m")
DRAWS = 8
CELL = ["gap_mm", "friction"]


def full(table, rng):
    """Return 24 motions, each in one orientation and in all variants."""
    motions = table["motion_id"].drop_duplicates().to_numpy()
    angles = table["incidence_deg"].drop_duplicates().to_numpy()
    chosen = rng.permutation(motions)[: motions.size // 2]
    angle = dict(zip(chosen, rng.choice(angles, chosen.size), strict=True))
    return table[table["motion_id"].map(angle) == table["incidence_deg"]]


def blocks(table, rng, complete_share=0.0):
    """Return all motions in both orientations, each in the cells of `motions.blocks`."""
    levels = table.groupby("motion_id")[DEFAULTS.im].median()
    levels = levels.iloc[rng.permutation(len(levels))]
    cells = list(table[CELL].drop_duplicates().sort_values(CELL).itertuples(index=False, name=None))
    cells = [cells[place] for place in rng.permutation(len(cells))]
    angles = sorted(table["incidence_deg"].unique())
    design = BlocksConfig(within=("skew_deg",), cells_per_motion=1, complete_share=complete_share)
    runs = assign(levels.tolist(), len(cells), len(angles), design)
    kept = {(levels.index[m], angles[a], *cells[c]) for m, a, c in np.argwhere(runs).tolist()}
    keys = table[["motion_id", "incidence_deg", *CELL]].itertuples(index=False, name=None)
    return table[[key in kept for key in keys]]


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


def main(full_run, spread_run):
    """Return the mean half-widths over draws of each design, and their ratios."""
    table, spread = pd.read_parquet(full_run), pd.read_parquet(spread_run)
    limits = Path(__file__).parents[1] / "config" / "limit_states.yaml"
    states = [
        state
        for state in with_column_failure(load_limit_states(limits), table.columns)
        if state.key in HEADLINE_STATES or state.component == "column_failure"
    ]
    rng = np.random.default_rng(45)
    found, sizes = {}, {}
    for name, design, source, draws in (
        ("all", lambda rows, _: rows, table, 1),
        ("full", full, table, DRAWS),
        ("blocks", blocks, table, DRAWS),
        ("default", lambda rows, rng: blocks(rows, rng, 0.17), table, DRAWS),
        ("spread", lambda rows, _: rows, spread, 1),
    ):
        samples = [design(source, rng) for _ in range(draws)]
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
    text = json.dumps(main(*sys.argv[1:3]), indent=1)
    Path(__file__).with_suffix(".json").write_text(text + "\n", encoding="utf-8")

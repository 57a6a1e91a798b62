"""Half-widths of effects of osb1 in designs with equal numbers of analyses.

TURNED and STRAIGHT are runs of 48 recorded pairs in all twelve variants, at 0 and at 90 degrees.
Designs are parts of them: `full`, 32 pairs in all variants at one orientation, which alternates;
`blocks`, 32 pairs at both orientations in two cells of gap and friction each, as in the default
study; `bands`, 48 pairs at both orientations in one cell each; `spread` has the design of `bands`,
but levels over the whole range. `all` has all runs.

Usage: design_efficiency.py STRAIGHT.parquet TURNED.parquet SPREAD.parquet
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
DRAWS = 20
CELL = ["gap_mm", "friction"]
ANGLE = "incidence_deg"


def part_of(table, motions, runs):
    """Return the runs of motions at the incidences and in the cells of `assign`."""
    cell, angle = table.groupby(CELL).ngroup(), table.groupby(ANGLE).ngroup()
    place = pd.Index(motions).get_indexer(table["motion_id"])
    return table[(place >= 0) & runs[place, angle, cell]]


def some_motions(table, rng):
    """Return 32 of the motions."""
    motions = table["motion_id"].drop_duplicates().to_numpy()
    return motions[np.sort(rng.permutation(motions.size)[:32])]


def full_design(table, rng):
    """Return the runs of 32 motions in all variants, at one orientation each."""
    motions = some_motions(table, rng)
    runs = np.zeros((motions.size, 2, 4), dtype=bool)
    runs[np.arange(motions.size), np.arange(motions.size) % 2] = True
    return part_of(table, motions, runs)


def blocks_design(table, rng, cells_per_motion=2, motions=None):
    """Return the runs of 32 motions at both orientations in some cells each."""
    motions = some_motions(table, rng) if motions is None else motions
    levels_g = table.groupby("motion_id")[DEFAULTS.im].first().loc[motions].to_numpy()
    blocks = BlocksConfig(cells_per_motion=cells_per_motion, complete_share=0.0)
    return part_of(table, motions, assign(levels_g, 4, 2, blocks))


def bands_design(table, rng):
    """Return the runs of all motions at both orientations in one cell each."""
    return blocks_design(table, rng, 1, table["motion_id"].drop_duplicates().to_numpy())


def half_widths(table, states):
    """Return the half-width of ln ratio of the pooled effects of largest values, by effect."""
    wanted = [state.demand for state in states]
    checked = demand_table.prepared(table.reset_index(drop=True), [*wanted, *DEMANDS], DEFAULTS)
    models = fit_models(checked.table, states, DEFAULTS)
    tables = [
        median_effects(models, states, DEFAULTS),
        effect_tables(checked.table, DEMANDS, DEFAULTS).effects,
    ]
    pooled = pd.concat([part[part["scope"] == "pooled"] for part in tables])
    last = pooled.groupby("axis")["to_value"].transform("max") == pooled["to_value"]
    pooled = pooled[last & pooled["demand"].isin([*HEADLINE_STATES, *DEMANDS])]
    width = 0.5 * np.log(pooled["ci_high"] / pooled["ci_low"])
    return dict(zip(pooled["axis"] + " " + pooled["demand"], width, strict=True))


def main(straight, turned, spread_run):
    """Return the mean half-widths over draws of each design, and their ratios."""
    table = pd.concat(map(pd.read_parquet, (straight, turned)), ignore_index=True)
    spread = pd.read_parquet(spread_run)
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
        ("full", full_design, table, DRAWS),
        ("blocks", blocks_design, table, DRAWS),
        ("bands", bands_design, table, 1),
        ("spread", None, spread, 1),
    ):
        samples = [design(source, rng) if design else source for _ in range(draws)]
        sizes[name] = len(samples[0])
        widths = pd.DataFrame([half_widths(sample, states) for sample in samples])
        found[name] = widths.mean()
        found[f"{name}_without"] = widths.isna().sum()  # draws without an interval
    rows = pd.DataFrame(found)
    rows["blocks_over_full"] = rows["blocks"] / rows["full"]
    rows["bands_over_spread"] = rows["bands"] / rows["spread"]
    effects = rows.round(4).replace({np.nan: None}).to_dict("index")
    return {"analyses": sizes, "draws": DRAWS, "half_widths": effects}


if __name__ == "__main__":
    text = json.dumps(main(*sys.argv[1:4]), indent=1)
    Path(__file__).with_suffix(".json").write_text(text + "\n", encoding="utf-8")

"""Synthetic demands tables of any size: rows of the schema from a model of demand.

ln demand = ln a + b ln x + scatter of the motion + effects of the axes + small scatter of the run.
"""

from itertools import islice, product
from typing import Final

import numpy as np
import pandas as pd
import pyarrow as pa

from skewbridge.demands.columns import COLUMNS, DEMAND_COLUMNS, INTENSITY_COLUMNS
from skewbridge.demands.tables import demands_schema
from skewbridge.demands.validity import BEYOND_MODEL, COMPLETE, completed
from skewbridge.statuses import COLLAPSE, OK
from skewbridge.variant.variant import Variant

IM: Final = "im_saavg_rotd50_g"
SEED: Final = 20261122
#: Median at 1 g, slope and scatter between motions of demands; others take those of `_OTHERS`.
MODELS: Final = {
    "column_shear_kn": (2000.0, 0.25, 0.12),
    "column_shear_dcr": (0.62, 0.22, 0.10),
    "column_drift_ratio": (0.035, 1.0, 0.35),
    "drift_over_capacity": (0.5, 1.0, 0.35),
    "column_curvature_ductility": (6.0, 1.1, 0.40),
    "column_residual_drift_ratio": (0.004, 1.5, 0.60),
    "deck_disp_m": (0.25, 1.0, 0.35),
    "deck_rotation_rad": (0.004, 1.0, 0.45),
    "unseating_m": (0.15, 1.0, 0.40),
    "bearing_disp_m": (0.22, 1.0, 0.38),
    "abutment_passive_m": (0.08, 1.2, 0.50),
    "abutment_active_m": (0.02, 0.8, 0.50),
    "abutment_transverse_m": (0.06, 0.9, 0.45),
    "shear_key_disp_m": (0.05, 1.0, 0.5),
}
_OTHERS: Final = (0.5, 0.3, 0.3)
_EFFECTS: Final = {"skew_deg": 0.004, "gap_mm": 0.001, "friction": -0.1}
_RUN_SCATTER: Final = 0.05
# drift at which a run collapses; enough runs reach it to test censored fits
_COLLAPSE_DRIFT: Final = 0.10


def grid_of(count: int) -> list[Variant]:
    """Return ``count`` variants, a hundred of each bridge: skews, gaps and frictions."""
    bridges = (f"b{number:03d}" for number in range(-(-count // 100)))
    axes = ((10, 25, 51, 76, 102), (0, 15, 30, 45, 60), (0, 25, 50, 75))
    every = (
        Variant(
            bridge=bridge, abutment="contact_friction", skew_deg=skew, gap_mm=gap, friction_pct=mu
        )
        for bridge, gap, skew, mu in product(bridges, *axes)
    )
    return list(islice(every, count))


def synthetic_rows(variants: int, motions: int, seed: int = SEED) -> pd.DataFrame:
    """Return a table of demands with every column of the schema, sorted by its key."""
    rng = np.random.default_rng(seed)
    grid = sorted(grid_of(variants), key=lambda variant: variant.slug)
    rows = variants * motions
    axes = {
        name: np.repeat([each.values()[name] for each in grid], motions)
        for name in grid[0].values()
    }
    ln_im = np.log(np.geomspace(0.1, 1.5, motions))
    x = np.tile(ln_im, variants)
    effect = sum(slope * axes[name] for name, slope in _EFFECTS.items())
    found: dict[str, object] = {
        "variant": np.repeat([each.slug for each in grid], motions),
        "bridge": np.repeat([each.bridge for each in grid], motions),
        "abutment": "contact_friction",
        **axes,
        "motion_id": np.tile([f"m{m:05d}" for m in range(motions)], variants),
        "scale": 1.0,
        "incidence_deg": 0.0,
    }
    for column in INTENSITY_COLUMNS:
        other = rng.normal(size=motions) * (0.0 if column.name == IM else 0.3)
        found[column.name] = np.tile(np.exp(ln_im + other), variants)
    for column in DEMAND_COLUMNS:
        median, slope, scatter = MODELS.get(column.name, _OTHERS)
        own = np.tile(rng.normal(size=motions) * scatter, variants)
        noise = rng.normal(size=rows) * _RUN_SCATTER
        found[column.name] = np.exp(np.log(median) + slope * x + own + effect + noise)
    collapsed = found["column_drift_ratio"] >= _COLLAPSE_DRIFT
    found["status"] = np.where(collapsed, COLLAPSE, OK)
    for column in COLUMNS:
        if column.name not in found:
            empty = {"text": "", "integer": 0, "number": 0.0, "boolean": False}
            found[column.name] = empty[column.kind]
    table = pd.DataFrame(found)
    table[COMPLETE] = completed(table["status"], table[BEYOND_MODEL])
    table["steps_by_rung"] = "1000"
    table["run_key"] = [f"{number:064x}" for number in range(rows)]
    return table[[column.name for column in COLUMNS]]


def arrow_table(rows: pd.DataFrame) -> pa.Table:
    """Return the rows with the schema of results/demands.parquet."""
    return pa.Table.from_pandas(rows, schema=demands_schema(), preserve_index=False)

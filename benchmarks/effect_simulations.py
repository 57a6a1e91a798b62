"""How often pooled effects, verdicts in their family and factor tests are right: simulated studies.

`python benchmarks/effect_simulations.py` reruns the stored simulations (some ten minutes on one
core); a test reads them and reruns a few.

A simulated study has the axes of the default study. ln demand = effects + scatter of the motion +
its own reaction to each axis + scatter of the run, as wide as measured in the default study (pairs:
3 to 10 %, of which a fifth is common to all cells). A run collapses where its demand passes a
limit, and keeps its demand up to there: the limit is such that 0, 5 or 20 % of all runs do.
"""

import json
import time
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
from scipy import stats

from skewbridge.fragility.methods.motion_means import MotionMeans
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.effects import paired_effects
from skewbridge.fragility.tables.factors import level_means
from skewbridge.variant.variant import Variant

SIMULATIONS: Final = 1000
SEED: Final = 20261122
COLLAPSES: Final = (0.0, 0.05, 0.2)
MOTIONS: Final = (16, 32)
AXES: Final = ("skew_deg", "gap_mm", "friction")
GRID: Final = {"skew_deg": (0, 30, 60), "gap_mm": (25, 51), "friction": (0.0, 0.5)}
DEMANDS: Final = ("column_drift_ratio", "deck_disp_m", "unseating_m")
RUN_SCATTER: Final = (0.03, 0.04, 0.07)
MARGIN: Final = 0.05
#: Change of ln demand per step of an axis, in the studies of coverage.
EFFECTS: Final = {"skew_deg": 0.08, "gap_mm": 0.03, "friction": -0.04}


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """How often something happened, with the exact 95 % bounds of its probability.

    Attributes:
        what: What was counted.
        motions: Motions of a study.
        collapse: Share of the runs that collapse.
        share: Share of the simulations.
        low: Lower bound.
        high: Upper bound.
        simulations: Number of them.
    """

    what: str
    motions: int
    collapse: float
    share: float
    low: float
    high: float
    simulations: int


def share_of(what: str, motions: int, collapse: float, hits: list[bool]) -> Share:
    """Return the share of hits with the bounds of Clopper and Pearson."""
    found = stats.binomtest(sum(hits), len(hits)).proportion_ci(0.95)
    return Share(
        what=what,
        motions=motions,
        collapse=collapse,
        share=sum(hits) / len(hits),
        low=float(found.low),
        high=float(found.high),
        simulations=len(hits),
    )


def frame(motions: int) -> pd.DataFrame:
    """Return the keys of a study without its demands, one row per variant and motion."""
    rows = []
    for values in product(*GRID.values()):
        named = dict(zip(GRID, values, strict=True))
        variant = Variant.at("osb1", "contact_friction", named)
        rows += [
            {"variant": variant.slug, "bridge": "osb1", "abutment": "contact_friction", **named}
            | {"motion_id": f"m{m:02d}", "scale": 1.0, "incidence_deg": 0.0, "status": "ok"}
            for m in range(motions)
        ]
    return pd.DataFrame(rows)


def simulate(
    keys: pd.DataFrame, effects: dict[str, float], collapse: float, rng: np.random.Generator
) -> pd.DataFrame:
    """Return a study with demands; their collapse limit is where so many runs end."""
    motion = keys["motion_id"].str[1:].astype(int).to_numpy()
    steps = {name: np.searchsorted(GRID[name], keys[name].to_numpy()) for name in AXES}
    common = 0.5 * rng.normal(size=motion.max() + 1)
    table = keys.copy()
    ended = np.zeros(len(keys), dtype=bool)
    demands = []
    for scatter in RUN_SCATTER:
        own = common + 0.2 * rng.normal(size=common.size)
        ln_d = own[motion] + scatter * rng.standard_t(6, size=motion.size) / np.sqrt(1.5)
        for name in AXES:
            # each motion reacts to each value of an axis in its own way
            reaction = 0.7 * scatter * rng.normal(size=(common.size, len(GRID[name])))
            ln_d += effects[name] * steps[name] + reaction[motion, steps[name]]
        demands.append(np.exp(ln_d))
    if collapse:
        limit = np.quantile(demands[0], 1.0 - collapse)
        ended = demands[0] > limit
        # all demands grew together up to the collapse
        cut = np.where(ended, limit / demands[0], 1.0)
        demands = [values * cut for values in demands]
    table["status"] = np.where(ended, "collapse", "ok")
    return table.assign(**dict(zip(DEMANDS, demands, strict=True)))


def pooled_coverage(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often the 95 % intervals of pooled effects hold the truth, by axis."""
    rng = np.random.default_rng(seed)
    settings = FitSettings(effect_confidence=0.95)
    keys = frame(motions)
    hits: dict[str, list[bool]] = {}
    for _ in range(simulations):
        found = paired_effects(simulate(keys, EFFECTS, collapse, rng), DEMANDS[:1], settings)
        for row in found[found["scope"] == "pooled"].to_dict("records"):
            steps = GRID[row["axis"]].index(row["to_value"])
            truth = float(np.exp(EFFECTS[row["axis"]] * steps))
            name = f"coverage, pooled {row['axis']} to {row['to_value']:g}"
            hits.setdefault(name, []).append(row["ci_low"] <= truth <= row["ci_high"])
    return [share_of(name, motions, collapse, found) for name, found in hits.items()]


def family_errors(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often any cell is called lower or higher where all effects lie on the margin.

    For comparison the same of the verdicts that each hold for themselves.
    """
    rng = np.random.default_rng(seed)
    keys = frame(motions)
    at_margin = dict.fromkeys(AXES, 0.0) | {"friction": float(np.log1p(MARGIN))}
    hits: dict[str, list[bool]] = {"verdict_family": [], "verdict": []}
    for _ in range(simulations):
        found = paired_effects(simulate(keys, at_margin, collapse, rng), DEMANDS)
        cells = found[(found["axis"] == "friction") & (found["scope"] == "variant")]
        for name, said in hits.items():
            said.append(bool(cells[name].isin(["lower", "higher"]).any()))
    return [
        share_of(f"type I at the margin, any {name}", motions, collapse, found)
        for name, found in hits.items()
    ]


def factor_errors(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often the F test at 5 % finds a factor that does nothing, by factor."""
    rng = np.random.default_rng(seed)
    keys = frame(motions)
    nothing = dict.fromkeys(AXES, 0.0)
    hits: dict[str, list[bool]] = {name: [] for name in AXES}
    for _ in range(simulations):
        study = simulate(keys, nothing, collapse, rng)
        for name, said in hits.items():
            test = MotionMeans.of(level_means(study, DEMANDS[0], name)).difference()
            said.append(test.p_value < 0.05)
    return [
        share_of(f"type I of the factor {name}", motions, collapse, found)
        for name, found in hits.items()
    ]


def interaction_errors(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often cells are said to differ (p_cells < 5 %) where the effect is the same."""
    rng = np.random.default_rng(seed)
    keys = frame(motions)
    hits: list[bool] = []
    for _ in range(simulations):
        found = paired_effects(simulate(keys, EFFECTS, collapse, rng), DEMANDS[:1])
        pooled = found[(found["axis"] == "friction") & (found["scope"] == "pooled")]
        hits.append(bool(pooled["p_cells"].iloc[0] < 0.05))
    return [share_of("type I of p_cells, friction", motions, collapse, hits)]


STUDIES: Final = (pooled_coverage, family_errors, factor_errors, interaction_errors)


def main() -> None:
    rows = []
    for study, motions, collapse in product(STUDIES, MOTIONS, COLLAPSES):
        begin = time.perf_counter()
        found = study(motions, collapse, SIMULATIONS, SEED)
        rows += [asdict(row) for row in found]
        for row in found:
            print(  # noqa: T201
                f"{row.what:45s} {motions:3d} motions, {collapse:4.0%} collapse:"
                f" {row.share:.3f} [{row.low:.3f}, {row.high:.3f}]",
                flush=True,
            )
        print(f"{time.perf_counter() - begin:.0f} s", flush=True)  # noqa: T201
    out = Path(__file__).with_suffix(".json")
    out.write_text(json.dumps({"seed": SEED, "rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

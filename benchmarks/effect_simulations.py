"""How often pooled effects, verdicts in their family and factor tests are right: simulated studies.

`python benchmarks/effect_simulations.py` reruns the stored simulations (some ten minutes on one
core); a test reads them and reruns a few.

A simulated study has the axes of the default study. ln demand = effects + scatter of the motion +
its own reaction to each axis + scatter of the run, as wide as measured in the default study (pairs:
3 to 10 %, of which a fifth is common to all cells). A run collapses where its demand passes a
limit, and keeps its demand up to there: the limit is such that 0, 5 or 20 % of all runs do.
"""

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import stats

from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.methods.motion_means import MotionMeans
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.fragility.tables.cell_changes import CellMeans, Changes
from skewbridge.fragility.tables.verdicts import FAMILY, HIGHER, LOWER, RATIO, judged

SIMULATIONS: Final = 500
SEED: Final = 20261122
COLLAPSES: Final = (0.0, 0.05, 0.2)
MOTIONS: Final = (16, 32)
GRID: Final = {"skew_deg": (0, 30, 60), "gap_mm": (25, 51), "friction": (0.0, 0.5)}
#: Scatter of a run within its motion: of drift, deck displacement and unseating.
RUN_SCATTER: Final = (0.03, 0.04, 0.07)
DIFFERENCES: Final = ("difference", "difference_low", "difference_high", "difference_margin")
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A simulated study.

    Attributes:
        ln_demands: ln of the peaks of each demand, shape (demands, motions, values of each axis).
        ended: Runs that collapsed, whose peaks are those up to then; shape as of one demand.
    """

    ln_demands: FloatArray
    ended: NDArray[np.bool_]


def simulate(
    motions: int, effects: Mapping[str, float], collapse: float, rng: np.random.Generator
) -> Study:
    """Return a study whose strongest runs collapse."""
    shape = (motions, *(len(values) for values in GRID.values()))
    common = 0.5 * rng.normal(size=motions)
    demands = []
    for scatter in RUN_SCATTER:
        # heavier tails than the normal distribution, with the same variance
        ln_d = scatter * rng.standard_t(6, size=shape) / np.sqrt(1.5)
        ln_d += (common + 0.2 * rng.normal(size=motions)).reshape(-1, 1, 1, 1)
        for place, (name, values) in enumerate(GRID.items(), start=1):
            # each motion reacts to each value of an axis in its own way
            own = 0.7 * scatter * rng.normal(size=(motions, len(values)))
            own += effects[name] * np.arange(len(values))
            ln_d += own.reshape(
                [motions if at == 0 else len(values) if at == place else 1 for at in range(4)]
            )
        demands.append(ln_d)
    ln_demands = np.array(demands)
    # all demands of a run grew together up to its collapse
    limit = np.quantile(ln_demands[0], 1.0 - collapse) if collapse else np.inf
    over = np.maximum(ln_demands[0] - limit, 0.0)
    return Study(ln_demands=ln_demands - over, ended=over > 0.0)


def cell_means(study: Study, demand: int, axis: str, to: int) -> CellMeans:
    """Return the changes from the first value of an axis to another, in all cells."""
    place = 1 + list(GRID).index(axis)
    ends = {
        end: (
            np.take(study.ln_demands[demand], value, place),
            np.take(study.ended, value, place),
        )
        for end, value in (("to", to), ("from", 0))
    }
    (top, top_ended), (bottom, bottom_ended) = ends["to"], ends["from"]
    motions = len(top)
    side = np.select(
        [~top_ended & ~bottom_ended, ~bottom_ended, ~top_ended], [0, 1, -1], default=2
    ).reshape(motions, -1)
    values = (top - bottom).reshape(motions, -1)
    changes = [
        Changes(
            values=values[:, cell],
            side=side[:, cell],
            used=side[:, cell] != 2,
            discordant=np.zeros(motions, dtype=np.bool_),
            reference=np.ones(motions),
        )
        for cell in range(values.shape[1])
    ]
    return CellMeans.of(changes, [np.arange(motions)] * len(changes), motions)


def pooled_effects(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often 95 % intervals of pooled effects hold the truth, and p_cells is wrong.

    The effect is the same in all cells, so that p_cells < 5 % is a false alarm.
    """
    rng = np.random.default_rng(seed)
    hits: dict[str, list[bool]] = {}
    for _ in range(simulations):
        study = simulate(motions, EFFECTS, collapse, rng)
        for axis, values in GRID.items():
            for to in range(1, len(values)):
                joint = cell_means(study, 0, axis, to).joint
                low, high = joint.average().interval(0.95)
                change = f"{axis} to {values[to]:g}"
                held = low <= EFFECTS[axis] * to <= high
                hits.setdefault(f"coverage, pooled {change}", []).append(held)
                alarm = joint.difference().p_value < 0.05
                hits.setdefault(f"type I of p_cells, {change}", []).append(alarm)
    return [share_of(name, motions, collapse, found) for name, found in sorted(hits.items())]


def family_errors(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often any cell is called lower or higher where all effects lie on the margin.

    For comparison the same of the verdicts that each hold for themselves.
    """
    rng = np.random.default_rng(seed)
    at_margin = dict.fromkeys(GRID, 0.0) | {"friction": float(np.log1p(MARGIN))}
    rows = []
    for number in range(simulations):
        study = simulate(motions, at_margin, collapse, rng)
        for demand in range(len(RUN_SCATTER)):
            for test in cell_means(study, demand, "friction", 1).tests:
                low, high = np.exp(test.interval(DEFAULTS.effect_confidence))
                ends = {"ratio": np.exp(test.value), "ci_low": low, "ci_high": high}
                rows.append({"bridge": number, "dof": test.dof, **ends})
    table = pd.DataFrame(rows).assign(
        **dict.fromkeys(FAMILY[1:], ""),
        **dict.fromkeys(DIFFERENCES, np.nan),
        margin=MARGIN,
        level=DEFAULTS.effect_confidence,
        judged_by=RATIO,
        n_discordant=0,
        n_pairs=motions,
    )
    found = judged(table)
    return [
        share_of(
            f"type I at the margin, any {name}",
            motions,
            collapse,
            list(found[name].isin([LOWER, HIGHER]).groupby(found["bridge"]).any()),
        )
        for name in ("verdict_family", "verdict")
    ]


def factor_errors(motions: int, collapse: float, simulations: int, seed: int) -> list[Share]:
    """Return how often the F test at 5 % finds a factor that does nothing, by factor.

    Runs that collapsed are left out, as `level_means` does.
    """
    rng = np.random.default_rng(seed)
    nothing = dict.fromkeys(GRID, 0.0)
    hits: dict[str, list[bool]] = {name: [] for name in GRID}
    for _ in range(simulations):
        study = simulate(motions, nothing, collapse, rng)
        ln_d = np.where(study.ended, np.nan, study.ln_demands[0])
        for place, (name, values) in enumerate(GRID.items(), start=1):
            levels = np.moveaxis(ln_d, place, -1).reshape(motions, -1, len(values))
            whole = np.isfinite(levels).all(axis=2)
            kept = [
                own[good].mean(axis=0)
                for own, good in zip(levels, whole, strict=True)
                if good.any()
            ]
            test = MotionMeans.of(np.array(kept)).difference()
            hits[name].append(test.p_value < 0.05)
    return [
        share_of(f"type I of the factor {name}", motions, collapse, found)
        for name, found in hits.items()
    ]


STUDIES: Final = (pooled_effects, family_errors, factor_errors)


def main() -> None:
    """Simulate all cells, or those of the numbers of motions that are given."""
    out = Path(__file__).with_suffix(".json")
    kept = {_cell(row): row for row in json.loads(out.read_text(encoding="utf-8"))["rows"]}
    chosen = [int(number) for number in sys.argv[1:]] or MOTIONS
    for study, motions, collapse in product(STUDIES, chosen, COLLAPSES):
        for row in study(motions, collapse, SIMULATIONS, SEED):
            kept[_cell(asdict(row))] = asdict(row)
            sys.stderr.write(
                f"{row.what:45s} {motions:3d} motions, {collapse:4.0%} collapse:"
                f" {row.share:.3f} [{row.low:.3f}, {row.high:.3f}]\n"
            )
        rows = sorted(kept.values(), key=_cell)
        out.write_text(json.dumps({"seed": SEED, "rows": rows}, indent=1) + "\n", encoding="utf-8")


def _cell(row: Mapping[str, Any]) -> tuple[str, int, float]:
    return str(row["what"]), int(row["motions"]), float(row["collapse"])


if __name__ == "__main__":
    main()

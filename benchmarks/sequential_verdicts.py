"""Simulated studies that stop at a verdict: errors of verdicts and coverage of intervals.

`python benchmarks/sequential_verdicts.py` repeats the stored simulations; a test repeats a few.

The studies are those of `effect_simulations`: heavy-tailed scatter, effects that differ between
motions, runs that collapse. Each is tested with 12 to 64 motions and stops at the first verdict
about the margin. The true effect is zero, the margin or twice the margin. In ``unequal`` studies,
half of the pairs of variants have half of the motions; in ``turned`` studies of medians, each
motion runs at two angles of incidence with independent scatter.
"""

import json
import sys
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from common import share_of
from effect_simulations import AXIS, BOUNDS, DRIFT, GRID, SETTINGS, limit_of, simulate
from numpy.typing import NDArray

from skewbridge.fragility.demand_model import fit_models
from skewbridge.fragility.effects import UNKNOWN, Pairs, effect_row, effect_table, median_effects
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.motion_means import average, by_motion
from skewbridge.fragility.verdicts import DECIDED, DEMAND, HIGHER, LOWER, NEGLIGIBLE, at_looks, kept

SEED: Final = 20261123
#: Number of motions at each test (look); fewer looks for medians, which take longer to fit.
LOOKS: Final = {name: tuple(range(12, 65, 4)) for name in ("demand", "unequal")}
LOOKS |= dict.fromkeys(("median", "turned"), (12, 24, 36, 48, 64))
SIMULATIONS: Final = dict.fromkeys(LOOKS, 500) | {"turned": 500}
#: Number of runs of a variant under one motion.
RUNS: Final = dict.fromkeys(LOOKS, 1) | {"turned": 2}
MARGIN: Final = float(np.log1p(SETTINGS.margin))
#: True effects in margins.
EFFECTS: Final = (0.0, 1.0, 2.0)
#: Limit state in the studies of medians; demands reach it in the middle of the intensities.
STATE: Final = LimitState(
    component="simulated", name="moderate", demand=DRIFT, threshold=0.45, dispersion=0.0
)


def rows_of_demand(
    pairs: Pairs, number: int, numbers: NDArray[np.int_]
) -> Iterator[dict[str, Any]]:
    """Yield the pooled effect, then those of variant pairs, which have ``numbers`` motions each."""
    ln_ratios = np.log(np.divide(*pairs.ends(DRIFT)))
    estimates = []
    for (_, rows), own_number in zip(pairs.cells, numbers, strict=True):
        own = rows[(pairs.motions[rows] < own_number) & (pairs.side[rows] != UNKNOWN)]
        estimates.append(by_motion(ln_ratios[own], pairs.side[own], pairs.motions[own], number))
    blocks = [f"{motion}" for motion in range(number)]
    yield {"scope": "pooled"} | effect_row(average(estimates), blocks=blocks)
    for (place, _), own_number, estimate in zip(pairs.cells, numbers, estimates, strict=True):
        row = {"scope": "variant", **place, "n_pairs": own_number}
        yield row | effect_row(estimate, blocks=blocks)


def demands_of(pairs: Pairs, numbers: NDArray[np.int_], kind: str) -> pd.DataFrame:
    """Return the runs of a study whose pairs of variants have ``numbers`` motions each.

    In a ``turned`` study two neighbouring motions are one at two angles of incidence.
    """
    table = pairs.table
    allowed = np.empty(len(table), dtype=np.int_)
    for (_, rows), number in zip(pairs.cells, numbers, strict=True):
        allowed[rows] = number
    table = table[pairs.motions < allowed]
    runs = []
    for end, value in zip(("from", "to"), GRID[AXIS], strict=True):
        own = {name: table[f"{name}_{end}"] for name in (DRIFT, "status", "complete", SETTINGS.im)}
        runs.append(table[["motion_id", "skew_deg", "gap_mm"]].assign(**own, **{AXIS: value}))
    demands = pd.concat(runs, ignore_index=True)
    angle = 0.0
    if kind == "turned":
        number = demands["motion_id"].str[1:].astype(int)
        demands["motion_id"], angle = (number // 2).map("m{:03d}".format), 90.0 * (number % 2)
    names = demands["skew_deg"] + 1e3 * demands["gap_mm"] + 1e6 * demands[AXIS]
    return demands.assign(
        variant=names.astype(str),
        abutment="contact_friction",
        bridge=pairs.labels["bridge"],
        scale=1.0,
        incidence_deg=angle,
        beyond_model="",
    )


def effects_at(studies: Sequence[Pairs], number: int, kind: str) -> pd.DataFrame:
    """Return the effects of studies under their first motions; ``demand`` names the study."""
    cells = len(studies[0].cells)
    numbers = np.full(cells, number)
    if kind == "unequal":
        numbers[: cells // 2] = max(12, number // 2)
    if kind in ("median", "turned"):
        numbers *= RUNS[kind]
        runs = [demands_of(pairs, numbers, kind) for pairs in studies]
        demands = pd.concat(runs, ignore_index=True)
        models = fit_models(demands, [STATE], SETTINGS, further=[AXIS])
        effects = median_effects(models, [STATE], SETTINGS, axes=[AXIS])
        return effects.assign(demand=effects["bridge"], bridge="simulated")
    shared = {"quantity": DEMAND, "margin": SETTINGS.margin, "n_discordant": 0}
    rows = [
        {"n_pairs": number * cells, **shared, **pairs.labels, "demand": pairs.labels["bridge"]}
        | {"bridge": "simulated", **row}
        for pairs in studies
        for row in rows_of_demand(pairs, number, numbers)
    ]
    return effect_table(pd.DataFrame(columns=list(GRID)), rows)


def stopped(studies: Sequence[Pairs], kind: str) -> pd.DataFrame:
    """Return the pooled effect of each study at its first verdict about the margin."""
    running, history = list(studies), pd.DataFrame()
    ended: list[pd.DataFrame] = []
    for number in LOOKS[kind]:
        effects = effects_at(running, number, kind)
        effects = kept(at_looks(effects, LOOKS[kind], RUNS[kind]), history)
        history = pd.concat([history, effects], ignore_index=True)
        pooled = effects[effects["scope"] == "pooled"]
        done = pooled["verdict"].isin(DECIDED) | (number == LOOKS[kind][-1])
        ended.append(pooled[done].assign(motions=number))
        names = set(pooled["demand"][done])
        running = [pairs for pairs in running if pairs.labels["bridge"] not in names]
        if not running:
            break
    return pd.concat(ended, ignore_index=True)


def verdicts_at_stopping(
    kind: str, bounds: float, margins: float, simulations: int, seed: int
) -> list[dict[str, Any]]:
    """Return how often each verdict is wrong, the interval covers and the effect is decided.

    At the margin both ``higher`` and ``negligible`` are wrong; each has an error rate of 5 %.
    """
    of_median, truth = kind in ("median", "turned"), margins * MARGIN
    effects = dict.fromkeys(GRID, 0.0) | {AXIS: -truth if of_median else truth}
    rng = np.random.default_rng([seed, round(100 * bounds), round(margins), len(kind)])
    studies = [
        simulate(
            RUNS[kind] * LOOKS[kind][-1],
            effects,
            0.0,
            limit_of(bounds),
            rng,
            bridge=f"{number:03d}",
        )
        for number in range(simulations)
    ]
    rows = stopped(studies, kind)
    wrong = {LOWER: True, HIGHER: margins <= 1.0, NEGLIGIBLE: margins >= 1.0}
    hits = {f"wrong: {name}": rows["verdict"] == name for name, is_so in wrong.items() if is_so}
    hits["interval covers"] = rows["ci_low"].le(np.exp(truth)) & rows["ci_high"].ge(np.exp(truth))
    hits["decided"] = rows["verdict"].isin(DECIDED)
    case = {"kind": kind, "bounds": bounds, "effect_margins": margins}
    shares: list[dict[str, Any]] = []
    for what, values in hits.items():
        share, low, high = share_of(values.tolist())
        found = {"what": what, "share": share, "low": low, "high": high}
        shares.append(case | found | {"simulations": len(values)})
    return [row | {"mean_motions": float(rows["motions"].mean())} for row in shares]


def main() -> None:
    """Simulate all cases and store each when it is done; arguments select kinds of studies."""
    out = Path(__file__).with_suffix(".json")
    names = ("kind", "bounds", "effect_margins", "what")
    stored = json.loads(out.read_text(encoding="utf-8"))["rows"] if out.exists() else []
    rows = {tuple(row[name] for name in names): row for row in stored}
    for kind, bounds, margins in product(sys.argv[1:] or LOOKS, BOUNDS, EFFECTS):
        new = verdicts_at_stopping(kind, bounds, margins, SIMULATIONS[kind], SEED)
        rows |= {tuple(row[name] for name in names): row for row in new}
        ordered = [rows[key] for key in sorted(rows)]
        out.write_text(json.dumps({"seed": SEED, "rows": ordered}, indent=1) + "\n", "utf-8")
        sys.stderr.write(f"{kind}, {bounds:.0%} bounds, {margins:g} margins: {new[-1]}\n")


if __name__ == "__main__":
    main()

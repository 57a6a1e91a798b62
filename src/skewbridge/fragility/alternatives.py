"""Effects on demands under each value of the modelling options that are drawn for every motion.

Each motion has its own value of every such option (`uncertainty.alternatives`), the same in all
variants. The ln ratios of an effect are regressed on these values, all options at once. A motion
draws its values independently of its event, so the jackknife leaves out single motions.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.files.tables import Floats, Index, Row
from skewbridge.fragility import demand_table, verdicts
from skewbridge.fragility.effects import EXACT, STEP, Pairs, all_pairs
from skewbridge.fragility.motion_means import by_motion
from skewbridge.fragility.settings import EFFECT_CONFIDENCE
from skewbridge.variant.random_properties import CHOICE_PREFIX, drawn_options

ALTERNATIVE_COLUMNS: Final = demand_table.described("alternatives")
#: Smallest number of motions with each value of an option, and of degrees of freedom.
_LEAST, _LEAST_DOF = 3, 8


def alternative_effects(demands: pd.DataFrame) -> pd.DataFrame:
    """Return the table `alternatives`: headline effects under each value of each drawn option."""
    options = [f"{CHOICE_PREFIX}{name}" for name in drawn_options(map(str, demands))]
    names = demands_for("headline", demands.columns)
    pairs = all_pairs(demands, [*names, *options]) if options else ()
    rows = [row for pair in pairs for name in names for row in _rows(pair, name, options)]
    table = pd.DataFrame(rows, columns=list(ALTERNATIVE_COLUMNS))
    keys = [table[name] for name in (*demand_table.BRIDGE_COLUMNS, "axis", *STEP, "demand")]
    return table.assign(p=table["p"].astype(np.float64).groupby(keys).transform(verdicts.holm))


def _rows(pairs: Pairs, name: str, choices: Sequence[str]) -> Iterator[Row]:
    """Yield the rows of table `alternatives` for the demand ``name``; none with too few motions.

    ``choices`` are the columns of the options.
    """
    ratios, _ = pairs.changes(name, None)
    pooled, *cells = pairs.means(ratios)
    for (_, cell_pairs), cell in zip(pairs.cells, cells, strict=True):
        ratios[cell_pairs] += pooled.estimate - cell.estimate  # an effect may differ between cells
    is_used = np.isfinite(ratios)
    motions, side = pairs.motions[is_used], pairs.side[is_used]
    # name of each option, its values, and the number of the value of each pair
    options: list[tuple[str, list[str], Index]] = []
    design = np.zeros((motions.size, 0))
    for column in choices:
        drawn = pairs.table[f"{column}_from"].astype(object)
        texts = drawn[is_used].fillna("").astype(str)
        levels, numbers = np.unique(texts[texts != ""], return_inverse=True)
        if levels.size < 2 or numbers.size < motions.size:  # the option does not act on the bridge
            continue
        counts = [np.unique(motions[numbers == level]).size for level in range(levels.size)]
        if min(counts) < _LEAST:
            return
        # deviations from the mean of all values: the last value has minus the sum of the others
        signs = np.vstack([np.eye(levels.size - 1), -np.ones(levels.size - 1)])
        design = np.hstack([design, signs[numbers]])
        options.append((column.removeprefix(CHOICE_PREFIX), levels.tolist(), numbers))
    parameters = 1 + design.shape[1]
    if not options or np.unique(motions[side == EXACT]).size < parameters + _LEAST_DOF:
        return
    _, motions = np.unique(motions, return_inverse=True)
    fit = by_motion(ratios[is_used], side, motions, int(motions.max()) + 1, design)
    if not np.all(np.isfinite(fit.estimate)):
        return
    share = _explained_share(ratios[is_used], design @ fit.estimate[1:], motions, side, parameters)
    position = 1
    for option, levels, numbers in options:
        size = len(levels) - 1
        contrasts = np.zeros((parameters, size + 1))
        contrasts[position : position + size] = np.hstack([np.eye(size), -np.ones((size, 1))])
        position += size
        change = fit.combined(contrasts)
        ratio_and_ends = np.exp([change.estimate, *change.interval(EFFECT_CONFIDENCE)])
        for number, level in enumerate(levels):
            columns = dict(zip(verdicts.RATIOS, ratio_and_ends[:, number].tolist(), strict=True))
            row = {**pairs.labels, "demand": name, "option": option, "value": level, **columns}
            row["effect"] = float(np.exp(fit.estimate[0] + change.estimate[number]))
            # rounded: both values of an option with two must have the same p
            row["p"] = round(float(change.p_value()[number]), 12)
            row["n_motions"] = np.unique(motions[numbers == number]).size
            yield row | {"level": EFFECT_CONFIDENCE, "share": share}


def _explained_share(
    ratios: Floats, explained: Floats, motions: Index, side: Index, parameters: int
) -> float:
    """Return the share of the variance between motions due to the options (adjusted R squared).

    ``explained`` (n,) is the part of the ln ratios that the options explain; see `Pairs.side`.
    """
    exact = side == EXACT
    count = np.bincount(motions[exact])
    means = [np.bincount(motions[exact], y[exact])[count > 0] for y in (ratios, ratios - explained)]
    total, remaining = (np.var(mean / count[count > 0]) for mean in means)
    n_motions = np.count_nonzero(count)
    return max(0.0, 1.0 - float(remaining / total) * (n_motions - 1) / (n_motions - parameters))

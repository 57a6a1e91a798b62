"""Trial runs of a study: a few motions on a few variants, to choose the levels.

The analyses are stored in the journals of the study, which reuses those that it needs.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy.special import ndtr

from skewbridge.errors import InputError
from skewbridge.files.tables import records_of
from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.demand_table import prepared
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.lines import SATURATING
from skewbridge.motions.intensity import scaled_measures
from skewbridge.motions.levels import FACTOR_LIMITS, LEVEL_MEASURE, block_factors
from skewbridge.motions.record import Vector
from skewbridge.study.analyses import StudySetup, run_in_journal
from skewbridge.study.batch import Row, Workers
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import prepare_motions
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.variant import Variant

type Levels = tuple[float, float]

LEAST_MOTIONS: Final = 4  # for a line with its scatter
#: Lowest and highest levels to try, as multiples of the configured ones.
LOWEST: Final = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0)
# ASSUME the line of a demand is not extrapolated above 1.5 times the strongest level of the trial
# runs. Further trial runs, with the levels that the first proposed, may go further.
HIGHEST: Final = (0.6, 0.7, 0.8, 1.0, 1.2, 1.4, 1.5)
# A wider range is worth it if it brings more than this share of the states.
WORTH_WIDENING: Final = 0.01
# End of each axis at each corner: four corners have both ends of each of three axes twice, and
# no two axes change together.
_CORNERS: Final = ((0, 0, 1, 1), (0, 1, 0, 1), (0, 1, 1, 0))
#: Name of the journal and of the folder with the motions.
_NAME: Final = "trial_runs"


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """Proposed range of the levels of a study.

    Attributes:
        share: Forecast share of the states in reach, of all variants, with outcomes on both sides
            if the levels lie as proposed; `configured_share` if they lie as configured.
        in_reach: Number of states of a variant that motions can reach, of `n_states`.
        states: By bridge, component and limit state: of how many variants it is in reach, the
            median level of its median in g, and both shares.
    """

    level_range_g: Levels
    configured_g: Levels
    share: float
    configured_share: float
    in_reach: int
    n_states: int
    states: list[dict[str, Any]]

    @property
    def config_lines(self) -> str:
        """The lines to paste into the configuration."""
        low_g, high_g = self.level_range_g
        return f"motions:\n  level_range_g: [{low_g:g}, {high_g:g}]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Strengths:
    """Levels (g) and measures by bridge of the motions at factor 1, arrays of shape (motions,)."""

    level_g: Vector
    measures: Mapping[str, list[dict[str, float]]]

    def allow(self, level_range_g: Levels) -> bool:
        """Return whether the motions reach these levels with factors within their limits."""
        factors = block_factors(self.level_g.tolist(), level_range_g)
        low, high = FACTOR_LIMITS
        return bool(factors.min() >= low and factors.max() <= high)

    def intensities(self, bridge: str, im: str, level_range_g: Levels) -> Vector:
        """Return the intensities for a bridge with the levels in this range."""
        factors = block_factors(self.level_g.tolist(), level_range_g).tolist()
        pairs = zip(self.measures[bridge], factors, strict=True)
        return np.array([scaled_measures(at_1, factor)[im] for at_1, factor in pairs])


def corner_variants(grid: GridConfig) -> list[str]:
    """Return the names of four variants of each bridge and abutment model, at ends of all axes."""
    slugs: dict[str, None] = {}
    for bridge, abutment, corner in product(grid.bridge, grid.abutment, range(4)):
        ends = {
            name: (min if _CORNERS[number % len(_CORNERS)][corner] == 0 else max)(values, key=abs)
            for number, (name, values) in enumerate(grid.values().items())
        }
        slugs[Variant.at(bridge, abutment, ends).normalised().slug] = None
    return list(slugs)


def run_trials(config: StudyConfig, motions: int) -> tuple[Proposal, list[Row]]:
    """Run the missing trial runs, the first motions on each of `corner_variants`; propose levels.

    Raises:
        InputError: A design without a range of levels, or more motions than the study has.
    """
    if config.motions.design != "scaled_cloud":
        raise InputError(
            "trial runs propose level_range_g of motions.design scaled_cloud, "
            f"not of {config.motions.design}"
        )
    folder = StudyFolder(Path(config.results))
    own = StudyFolder(folder.root / _NAME)
    prepare_motions(config, own)
    setup = StudySetup.of(config, own)
    if not LEAST_MOTIONS <= motions <= len(setup.suite):
        raise InputError(
            f"trial runs need {LEAST_MOTIONS} motions or more, at most those of the study "
            f"({len(setup.suite)}), got {motions}"
        )
    trials = replace(setup, folder=folder, suite=setup.suite[:motions])
    tasks = [task for slug in corner_variants(config.grid) for task in trials.tasks(slug)]
    cores, no_progress_s = len(os.sched_getaffinity(0)), config.batches.no_progress_s
    workers = Workers(count=cores, no_progress_s=no_progress_s)
    rows = run_in_journal(trials, _NAME, tasks, workers)
    states = load_limit_states(Path(config.fragility.limit_states))
    columns = list(dict.fromkeys(state.demand for state in states))
    runs = prepared(pd.DataFrame(rows), columns, config.fragility).table
    curves = fit_study(runs, states, config.fragility)
    measures: dict[str, list[dict[str, float]]] = {}
    for (bridge, _), at_1 in setup.measures.items():
        measures.setdefault(Path(bridge).stem, []).append(at_1)
    level_g = np.array([each.measures[LEVEL_MEASURE] / each.scale for each in setup.suite])
    low_g, high_g = config.motions.level_range_g
    strengths = Strengths(level_g=level_g, measures=measures)
    return propose(curves, strengths, (low_g, high_g)), rows


def propose(curves: pd.DataFrame, strengths: Strengths, configured_g: Levels) -> Proposal:
    """Return the narrowest range of levels that serves nearly the largest number of states.

    The demand of a state is that of its line in the cloud of the trial runs, beyond their levels
    as well: the probability that a motion exceeds the state follows from its intensity at its
    level. A state is in reach if its line rises, the level of its median is among those that are
    tried, and, where no trial run exceeds it, the line does not bend down and no outcome is unknown
    (then the columns fail before the state is reached). The configured range is proposed again if
    no other is better with factors within their limits; `InputError` without a state in reach.
    """
    lowest_g = [float(f"{configured_g[0] * factor:.2g}") for factor in LOWEST]
    highest_g = [float(f"{configured_g[1] * factor:.3g}") for factor in HIGHEST]
    im = str(curves["im"].iloc[0])
    lines = curves[(curves["method"] == "cloud") & (curves["b"] > 0.0) & (curves["sigma"] > 0.0)]
    ends = lines["warnings"].str.contains(SATURATING) | (lines["n_unknown"] > 0)
    lines = lines[~(ends & (lines["n_exceed"] == 0))]
    at_1 = {
        bridge: np.exp(np.mean(np.log([each[im] for each in measures])))
        for bridge, measures in strengths.measures.items()
    }
    per_g = lines["bridge"].map(at_1) / np.exp(np.mean(np.log(strengths.level_g)))
    median = np.exp((np.log(lines["threshold"]) - lines["ln_a"]) / lines["b"]) / per_g
    lines = lines.assign(median_g=median)[median.between(lowest_g[0], highest_g[-1])]
    if lines.empty:
        raise InputError(
            "the trial runs reach no limit state: check that the demands come from the trial runs"
        )
    allowed = filter(strengths.allow, product(lowest_g, highest_g))
    ranges = dict.fromkeys([configured_g, *allowed])
    shares = {each: _both_sides(lines, strengths, im, each) for each in ranges}
    means = {each: float(np.mean(share)) for each, share in shares.items()}
    good = [each for each, mean in means.items() if mean >= max(means.values()) - WORTH_WIDENING]
    chosen = configured_g if configured_g in good else min(good, key=lambda g: g[1] / g[0])
    of_both = lines.assign(configured=shares[configured_g], proposed=shares[chosen])
    groups = of_both.groupby(["bridge", "component", "limit_state"], sort=False)
    table = groups.agg(
        in_reach=("variant", "size"),
        median_g=("median_g", "median"),
        configured=("configured", "mean"),
        proposed=("proposed", "mean"),
    ).reset_index()
    return Proposal(
        level_range_g=chosen,
        configured_g=configured_g,
        share=means[chosen],
        configured_share=means[configured_g],
        in_reach=len(lines),
        n_states=int((curves["method"] == "cloud").sum()),
        states=records_of(table),
    )


def _both_sides(
    lines: pd.DataFrame, strengths: Strengths, im: str, level_range_g: Levels
) -> Vector:
    """Return for each line the probability of two motions or more on both sides of its state."""
    # ASSUME a fit that depends on one motion is unusable: both outcomes must occur twice
    shares = np.empty(len(lines))
    for bridge in lines["bridge"].unique():
        intensities = strengths.intensities(str(bridge), im, level_range_g)
        of_bridge = (lines["bridge"] == bridge).to_numpy()
        part = lines[of_bridge]
        a, b, s, c = (
            part[name].to_numpy()[:, None] for name in ("ln_a", "b", "sigma", "threshold")
        )
        above = ndtr((a + b * np.log(intensities)[None, :] - np.log(c)) / s)
        shares[of_bridge] = 1.0 - _fewer_than_two(above) - _fewer_than_two(1.0 - above)
    return shares


def _fewer_than_two(probability: Vector) -> Vector:
    """Return the probability of at most one of independent events, shape (lines,)."""
    p = np.clip(probability, 1.0e-9, 1.0 - 1.0e-9)
    none = np.prod(1.0 - p, axis=1)
    return none * (1.0 + np.sum(p / (1.0 - p), axis=1))

"""Inputs of a study: checks before the first analysis, and preparation of the motions."""

import logging
from collections.abc import Callable, Iterable
from dataclasses import asdict
from functools import partial
from pathlib import Path

import pandas as pd

from skewbridge.analysis.settings import NUMERICS
from skewbridge.bridge.frame import require_options
from skewbridge.bridge.library import load_structure
from skewbridge.demands.columns import DEMAND_COLUMNS, INTENSITY_COLUMNS, Column, joint_columns
from skewbridge.errors import InputError, raise_all
from skewbridge.files.digests import digest_of, provenance
from skewbridge.files.tables import write_frame
from skewbridge.files.text import shortened
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.levels import striped
from skewbridge.motions.suite import content_digest, suite_sources
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig, check_font, chosen_variants
from skewbridge.study.folder import StudyFolder
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.options import ModelOptions

logger = logging.getLogger(__name__)


def check_inputs(config: StudyConfig, cache: Path | None = None) -> None:
    """Check the bridges, motions, limit states, columns, font and variants of a configuration.

    The file `cache` records which motions have been read. The `InputError` has one line per error.
    """
    checks: list[Callable[[], object]] = [
        *(partial(load_structure, name) for name in config.bridges_with_periods()),
        *(partial(_check_options, name, config) for name in config.grid.bridge),
        partial(_check_column, "fragility.im", config.fragility.im, INTENSITY_COLUMNS),
        partial(_check_limit_states, Path(config.fragility.limit_states)),
        partial(check_font, config.figures.font),
        partial(motions_digest, config, cache),
        partial(chosen_variants, expand_grid(config.grid), config.modelling_choices.variants),
    ]
    if config.motions.design == "ida":
        demand = config.motions.ida_demand
        checks.append(partial(_check_column, "motions.ida_demand", demand, DEMAND_COLUMNS))
    faults: list[InputError] = []
    for check in checks:
        try:
            check()
        except InputError as error:
            faults.append(error)
    raise_all(faults)


def _check_options(bridge: str, config: StudyConfig) -> None:
    """Refuse axes and modelling options that do not act on a bridge."""
    usual = ModelOptions(**NUMERICS[config.accuracy]["model"])
    changed = (n for n, value in asdict(config.model).items() if value != getattr(usual, n))
    require_options(load_structure(bridge), (*config.grid.values(), *changed))


def motions_digest(config: StudyConfig, cache: Path | None) -> str:
    """Return the digest of the motions of a study, see `content_digest`."""
    digests = [
        content_digest(
            source.folder,
            source.count,
            t1_s=load_structure(CONDITIONING_BRIDGE).t1_s,
            level_range_g=config.motions.level_range_g,
            cache=None if cache is None else cache.with_stem(f"{cache.stem}{number or ''}"),
        )
        for number, source in enumerate(suite_sources(config.motions))
    ]
    return digests[0] if len(digests) == 1 else digest_of(*digests)


def _check_column(key: str, name: str, columns: Iterable[Column]) -> None:
    names = [column.name for column in columns]
    if name not in names:
        raise InputError(f"{key} must be one of {', '.join(names)}, got {shortened(name)}")


def _check_limit_states(path: Path) -> None:
    names = {column.name for column in DEMAND_COLUMNS}
    states = load_limit_states(path)
    names |= {column.name for column in joint_columns(state.demand for state in states)}
    lacking = [state for state in states if state.demand not in names]
    text = f"{path}: limit state %s/%s: the demands table has no column %r"
    raise_all(InputError(text % (each.component, each.name, each.demand)) for each in lacking)


def prepare_motions(study: StudyConfig) -> None:
    """Read and scale the motions, and write the tables of motions and intensity measures."""
    # Imported here: they load scipy.signal, and every job imports this module.
    from skewbridge.motions.intensity import motion_measures
    from skewbridge.motions.suite import prepare_suites, read_suite, write_suite

    folder, motions = StudyFolder(Path(study.results)), study.motions
    for name in study.grid.bridge:
        if useless := load_structure(name).ignored.intersection(study.uncertainty.drawn):
            listed = ", ".join(sorted(useless))
            logger.warning("random properties without effect on the script %s: %s", name, listed)
    suite = designed = prepare_suites(motions, t1_s=load_structure(CONDITIONING_BRIDGE).t1_s)
    if motions.design == "cloud":
        designed = suite.assign(scale=1.0)
    elif motions.design == "stripes":
        designed = striped(suite, motions.stripes_g, factor_limits=motions.factor_limits)
    factors = designed["scale"]
    counts = len(suite), len(designed)
    logger.info("%d motions, %d rows, factors %.2f to %.2f", *counts, factors.min(), factors.max())
    write_suite(designed, folder.suite)
    distinct = {motion.motion.motion_id: motion.motion for motion in read_suite(folder.suite)}
    periods_s = {name: load_structure(name).t1_s for name in study.grid.bridge}
    intensities = [
        {"bridge": name, "motion_id": motion_id, **motion_measures(motion, t1_s)}
        for name, t1_s in periods_s.items()
        for motion_id, motion in distinct.items()
    ]
    write_frame(pd.DataFrame(intensities), folder.intensities, provenance())

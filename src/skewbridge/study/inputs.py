"""Inputs of a study: checks before the first analysis, and preparation of the motions."""

import json
import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.analysis.settings import NUMERICS
from skewbridge.bridge.frame import require_options
from skewbridge.bridge.library import load_structure
from skewbridge.demands.columns import DEMAND_COLUMNS, INTENSITY_COLUMNS, Column, joint_columns
from skewbridge.demands.validity import with_derived_columns
from skewbridge.errors import InputError, raise_all
from skewbridge.files.digests import canonical, digest_of, layer_digest, provenance
from skewbridge.files.tables import Row, read_frame, write_frame
from skewbridge.files.text import read_json, shortened, write_text
from skewbridge.fragility import limit_states
from skewbridge.motions.folder import INDEX_NAME
from skewbridge.motions.levels import BLOCK, LEVEL_MEASURE, has_pilot
from skewbridge.motions.read import files_digest
from skewbridge.motions.suite import content_digest, suite_sources
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig, check_font
from skewbridge.study.folder import StudyFolder
from skewbridge.units import MM
from skewbridge.variant.axes import unit_doubts
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import with_draw
from skewbridge.variant.variant import ABUTMENTS, Variant

logger = logging.getLogger(__name__)

_GAP_OFFSET: Final = "gap_offset_mm"
# ASSUME a state is within the levels of a study if a demand of the pilot has half of its threshold
NEAR: Final = 0.5


def check_inputs(config: StudyConfig, cache: Path | None = None) -> None:
    """Check the bridges, motions, limit states, columns and font of a configuration.

    The file `cache` records which motions have been read. The `InputError` has one line per error.
    """
    checks: list[Callable[[], object]] = [
        *(partial(load_structure, name) for name in config.bridges_with_periods()),
        *(partial(_check_bridge, name, config) for name in config.grid.bridge),
        partial(_check_column, "fragility.im", config.fragility.im, INTENSITY_COLUMNS),
        partial(_check_limit_states, Path(config.fragility.limit_states)),
        partial(check_font, config.figures.font),
        partial(motions_digest, config, cache),
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


def _check_bridge(bridge: str, config: StudyConfig) -> None:
    """Check that all options act on a bridge, and that no gap of its variants exceeds a seat."""
    try:
        structure = load_structure(bridge)
    except InputError:
        return  # the check of the bridges reports it
    require_options(structure, (*config.grid.values(), *_changed_options(config)))
    law = config.uncertainty.drawn.get(_GAP_OFFSET)
    widest = {_GAP_OFFSET: law.high} if law else {}
    for variant, options in _variants(bridge, config):
        structure.description.require_seats(variant, with_draw(options, widest))


def _changed_options(config: StudyConfig) -> list[str]:
    """Return the keys of section ``model`` that differ from the defaults."""
    defaults = ModelOptions(**NUMERICS[config.accuracy]["model"])
    return [n for n, value in asdict(config.model).items() if value != getattr(defaults, n)]


def _variants(bridge: str, config: StudyConfig) -> Iterator[tuple[Variant, ModelOptions]]:
    """Yield the variants of a bridge with their modelling options."""
    for variant in expand_grid(config.grid.model_copy(update={"bridge": (bridge,)})):
        yield variant, replace(config.model, **dict(variant.options))


def axis_warnings(config: StudyConfig) -> Iterator[str]:
    """Yield warnings of axes without effect, of doubtful numbers, and of fast accuracy."""
    if config.accuracy == "fast":
        yield (
            "accuracy fast is for trials: its rows are often suspect (6 of 24 osb1 runs of 5 s), "
            "for steps with a looser convergence test or work above the friction limit"
        )
    motions, states = config.motions, list[limit_states.LimitState]()
    with suppress(InputError):  # `check_inputs` reports it
        suite, *_ = suite_sources(motions)
        if motions.count is not None and suite.count != motions.count:
            yield f"motions.count = {motions.count}, but {suite.name} has {suite.count} motions"
    if motions.design == "ida":
        state = partial(limit_states.LimitState, component="motions", name="ida_threshold")
        demand, threshold = motions.ida_demand, motions.ida_threshold
        states.append(state(demand=demand, threshold=threshold, dispersion=0.0))
    with suppress(InputError):  # `check_inputs` reports it
        states += limit_states.load_limit_states(Path(config.fragility.limit_states))
    yield from filter(None, (state.doubt for state in states))
    if curve := config.hazard_curve:
        yield from filter(None, [curve.doubt])
        bridges = config.grid.bridge if curve.depends_on_t1 else ()
        periods_s = [f"{load_structure(name).t1_s:.3g} s" for name in bridges]
        if len(set(periods_s)) > 1:
            text = f"{curve.source}: a hazard of {curve.im} is for one T1, but the bridges have"
            yield f"{text} {', '.join(periods_s)}: run a study for each, or use Sa(1.0 s)"
    for name in sorted(config.grid.values().keys() & _changed_options(config)):
        yield f"model.{name} has no effect: the variants have the values of grid.{name}"
    yield from unit_doubts(config.grid.skew_deg, config.grid.gap_mm)
    law = config.uncertainty.drawn.get(_GAP_OFFSET)
    without = ", ".join(name for name in config.grid.abutment if not ABUTMENTS[name].has_friction)
    for path in config.grid.bridge:
        bridge = load_structure(path)
        about = bridge.description
        yield from (f"{bridge.name}: {note}" for note in about.axis_notes)
        cases = _variants(path, config) if law else ()
        gaps_mm = {gap_m / MM for case in cases for gap_m in about.gaps_m(*case).values()}
        if law and (closed_mm := [gap_mm for gap_mm in gaps_mm if 0.0 < gap_mm < -law.low]):
            text = f"{bridge.name}: random gap offsets of {law.low:g} to {law.high:g} mm close its"
            yield f"{text} gap of {min(closed_mm):g} mm in some runs (uncertainty.{_GAP_OFFSET})"
        if without and about.joints_m:
            yield f"inner joints of {bridge.name} have no friction with abutment model {without}"


def motions_digest(config: StudyConfig, cache: Path | None) -> str:
    """Return the digest of the motions of a study, see `content_digest`, after their selection."""
    select_motions(config, cache)
    # a pilot has its medians after its motions are read
    medians_g = () if has_pilot(config.motions) else band_medians(config)
    digests: list[str] = [digest_of(medians_g)] if medians_g else []
    digests += [
        content_digest(
            source.folder,
            source.count,
            None if cache is None else cache.with_stem(f"{cache.stem}{number or ''}"),
        )
        for number, source in enumerate(suite_sources(config.motions))
    ]
    return digests[0] if len(digests) == 1 else digest_of(*digests)


def select_motions(config: StudyConfig, cache: Path | None) -> None:
    """Fill the folder of `motions.selection` unless target, candidates and code are unchanged.

    Writes the errors of each level into `motions/selection.json` of the results.
    """
    section, folder = config.motions.selection, config.folder
    if section is None:
        return
    target, sources = Path(section.target), list(map(Path, section.candidates))
    excluded = Path(section.without) if section.without else None
    input_digest = digest_of(
        canonical(asdict(section)),
        layer_digest(("errors.py", "units.py", "files", "motions")),
        files_digest(target, *([excluded / INDEX_NAME] if excluded else [])),
        *(
            content_digest(source, None, cache and cache.with_stem(f"candidates{number}"))
            for number, source in enumerate(sources)
        ),
    )
    index = folder.selected / INDEX_NAME
    is_written = folder.selection.is_file() and index.is_file()
    if is_written and read_json(folder.selection).get("state") == input_digest:
        return
    # here: it loads scipy.signal
    from skewbridge.motions import selection

    levels = selection.select_motions(
        target, section.values, sources, section.count, folder.selected, excluded
    )
    for doubt in (doubt for level in levels for doubt in level.doubts):
        logger.warning("motions.selection: %s", doubt)
    summaries = [level.summary for level in levels]
    write_text(folder.selection, json.dumps({"state": input_digest, "levels": summaries}, indent=1))


def _check_column(key: str, name: str, columns: Iterable[Column]) -> None:
    names = [column.name for column in columns]
    if name not in names:
        raise InputError(f"{key} must be one of {', '.join(names)}, got {shortened(name)}")


def _check_limit_states(path: Path) -> None:
    names = {column.name for column in DEMAND_COLUMNS}
    states = limit_states.load_limit_states(path)
    names |= {column.name for column in joint_columns(state.demand for state in states)}
    lacking = [state for state in states if state.demand not in names]
    text = f"{path}: limit state %s/%s: the demands table has no column %r"
    raise_all(InputError(text % (state.component, state.name, state.demand)) for state in lacking)


def band_medians(study: StudyConfig) -> tuple[float, ...]:
    """Return the median capacities (Sa_avg in g) that centre the levels, or () if not yet known.

    They come from the configuration, an earlier study, or finished trial runs (`run_pilot`).
    """
    bands, pilot = study.motions.bands, study.folder.pilot
    if bands is None or bands.medians_g:
        return bands.medians_g if bands else ()
    if bands.study is None:
        return tuple(read_json(pilot)) if pilot.is_file() else ()
    return medians_of(study, read_frame(StudyFolder(Path(bands.study)).demands))


def medians_of(study: StudyConfig, demands: pd.DataFrame) -> tuple[float, ...]:
    """Return rough median capacities (Sa_avg in g), one per bridge and headline state.

    Each is the level with the fewest runs on the wrong side: exceeding below, or not exceeding
    above. A state is left out if this level is below all runs. If it is above all runs, it is the
    largest level of a run, provided that a demand reaches `NEAR` times the capacity.
    """
    demands = with_derived_columns(demands).sort_values(LEVEL_MEASURE)
    states = limit_states.load_limit_states(Path(study.fragility.limit_states))
    states = limit_states.with_column_failure(states, list(map(str, demands)))
    medians: list[float] = []
    for _, rows in demands.groupby("bridge"):
        levels_g = rows[LEVEL_MEASURE].to_numpy(np.float64)
        for state in (s for s in states if s.key in limit_states.HEADLINE_STATES):
            ratios = np.nan_to_num(rows[state.demand].to_numpy(np.float64) / state.threshold)
            exceeds = ratios >= 1.0
            n_exceed_below = np.concatenate([[0], np.cumsum(exceeds)])
            errors = n_exceed_below + np.concatenate([np.cumsum(~exceeds[::-1])[::-1], [0]])
            nearest = int(errors.argmin())
            if nearest and (nearest < len(rows) or ratios.max() >= NEAR):
                levels_around = levels_g[nearest - 1 : nearest + 1]
                medians.append(round(float(np.exp(np.log(levels_around).mean())), 4))
    return tuple(medians)


def run_pilot(study: StudyConfig, workers: int) -> tuple[float, ...]:
    """Run the study under its first motions (trial runs); store and return its `medians_of`."""
    from skewbridge.study.analyses import StudySetup, run_in_journal

    setup = StudySetup.of(study, workers).of_motions(0, BLOCK)
    rows: list[Row] = []
    for slug in (variant.slug for variant in expand_grid(study.grid)):
        rows += run_in_journal(setup, slug, setup.planned_tasks(slug), of_variant=True)
    medians_g = medians_of(study, pd.DataFrame(rows))
    write_text(setup.folder.pilot, json.dumps(medians_g))
    logger.info("median Sa_avg of the trial runs: %s g", ", ".join(map("{:g}".format, medians_g)))
    return medians_g


def prepare_motions(study: StudyConfig, workers: int = 1) -> None:
    """Read and scale the motions, after trial runs if the levels need them; write their tables."""
    medians_g = band_medians(study)
    _write_motions(study, medians_g)
    if has_pilot(study.motions) and not medians_g:
        _write_motions(study, run_pilot(study, workers))


def _write_motions(study: StudyConfig, medians_g: Sequence[float]) -> None:
    # Imported here: they load scipy.signal, and every job imports this module.
    from skewbridge.motions.intensity import cut_warning, motion_measures, shaken_s
    from skewbridge.motions.suite import prepare_suites, read_suite, striped, write_suite

    folder, motions = study.folder, study.motions
    for text in axis_warnings(study):
        logger.warning("%s", text)
    for name in study.grid.bridge:
        if ineffective := load_structure(name).ignored.intersection(study.uncertainty.drawn):
            names = ", ".join(sorted(ineffective))
            logger.warning("random properties without effect on the script %s: %s", name, names)
    t1_s = load_structure(CONDITIONING_BRIDGE).t1_s
    suite = scaled = prepare_suites(motions, t1_s=t1_s, medians_g=medians_g)
    if motions.design == "cloud":
        scaled = suite.assign(scale=1.0)
    elif motions.design == "stripes":
        scaled = striped(suite, motions.stripes_g)
    factors = scaled["scale"]
    text = "%d motions in %d rows of the suite, scale factors %.2f to %.2f"
    logger.info(text, len(suite), len(scaled), factors.min(), factors.max())
    write_suite(scaled, folder.suite)
    motion_by_id = {motion.motion.motion_id: motion.motion for motion in read_suite(folder.suite)}
    for motion in motion_by_id.values():
        if text := cut_warning(motion, study.analysis.duration_s):
            logger.warning("%s", text)
    periods_s = {name: load_structure(name).t1_s for name in study.grid.bridge}
    intensities = [
        {
            "bridge": name,
            "motion_id": motion_id,
            **motion_measures(motion, t1_s),
            "shaken_s": shaken_s(motion, t1_s, motions.tail_ratio),
        }
        for name, t1_s in periods_s.items()
        for motion_id, motion in motion_by_id.items()
    ]
    write_frame(pd.DataFrame(intensities), folder.intensities, provenance())

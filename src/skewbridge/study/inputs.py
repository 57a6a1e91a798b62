"""Everything that a study reads, read and checked before its first analysis."""

from collections.abc import Callable
from pathlib import Path

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.demands.columns import DEMAND_COLUMNS, INTENSITY_COLUMNS
from skewbridge.errors import InputError, raise_all
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.content import content_digest
from skewbridge.reading import shortened
from skewbridge.study.chosen_variants import chosen_variants
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig
from skewbridge.study.figure_settings import check_font
from skewbridge.variant.grid import expand_grid


def check_inputs(config: StudyConfig, cache: Path | None = None) -> None:
    """Read bridges, motions and limit states of a study, look up columns and fonts that it names.

    Args:
        config: The configuration.
        cache: File that remembers which motions have been read (`content_digest`).

    Raises:
        InputError: Something is missing or wrong; the message has a line for each fault.
    """
    faults: list[InputError] = []

    def attempt(check: Callable[[], object]) -> None:
        try:
            check()
        except InputError as error:
            faults.append(error)

    for name in config.bridges_with_periods():
        attempt(lambda name=name: load_bridge(name))
    attempt(lambda: _check_measure(config.fragility.im))
    if config.motions.design == "ida":
        attempt(lambda: _check_ida_demand(config.motions.ida_demand))
    attempt(lambda: _check_limit_states(Path(config.fragility.limit_states)))
    attempt(lambda: check_font(config.figures.font))
    attempt(lambda: motions_digest(config, cache))
    attempt(lambda: chosen_variants(expand_grid(config.grid), config.modelling_choices.variants))
    raise_all(faults)


def motions_digest(config: StudyConfig, cache: Path | None) -> str:
    """Return the digest of what the motions of a study say, see `content_digest`.

    Raises:
        InputError: A folder or a motion is missing or malformed.
    """
    low_g, high_g = config.motions.level_range_g
    return content_digest(
        Path(config.motions.folder),
        config.motions.count,
        t1_s=load_bridge(CONDITIONING_BRIDGE).t1_s,
        level_range_g=(low_g, high_g),
        cache=cache,
    )


def _check_measure(name: str) -> None:
    known = [column.name for column in INTENSITY_COLUMNS]
    if name not in known:
        told = f"fragility.im must be one of {', '.join(known)}, got {shortened(name)}"
        raise InputError(told)


def _check_ida_demand(name: str) -> None:
    known = [column.name for column in DEMAND_COLUMNS]
    if name not in known:
        told = f"motions.ida_demand must be one of {', '.join(known)}, got {shortened(name)}"
        raise InputError(told)


def _check_limit_states(path: Path) -> None:
    known = {column.name for column in DEMAND_COLUMNS}
    raise_all(
        InputError(
            f"{path}: limit state {state.component}/{state.name}: the demands table has no column "
            f"{state.demand!r}"
        )
        for state in load_limit_states(path)
        if state.demand not in known
    )

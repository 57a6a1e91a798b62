"""Which choices of the modeller move the demands as much as friction, gap and skew do.

On a few motions each choice of `study.choices` is changed alone, and the demands are compared with
those of the configured model motion by motion; beside them stand the axes of the grid, from their
lowest to their highest value on the same motions.
"""

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.provenance.tables import provenance, write_frame
from skewbridge.statuses import OK
from skewbridge.study.batch import run_tasks
from skewbridge.study.choices import CHOICES, Choice, value_text
from skewbridge.study.guard import Workers
from skewbridge.study.journal import open_journal, read_journals
from skewbridge.study.keys import run_key
from skewbridge.study.progress import log_failure
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import Task
from skewbridge.variant.variant import Variant, parse_slug

logger = logging.getLogger(__name__)

#: Columns of the table, with what they mean.
CHOICE_COLUMNS: Final = {
    "bridge": "catalogue name of the bridge",
    "abutment": "abutment model",
    "kind": "`choice` of the modeller, or `axis` of the grid",
    "name": "key of the option, or name of the axis",
    "from_value": "the configured value; of an axis the lowest (of skew the smallest angle)",
    "to_value": "the value tried; of an axis the highest",
    "demand": "demand column",
    "ratio": "geometric mean over the pairs of the demand at to_value over that at from_value",
    "lowest": "smallest ratio of one pair",
    "highest": "largest ratio of one pair",
    "n": "pairs in which both runs ended `ok` with a demand above zero",
    "n_failed": "pairs in which a run did not end `ok`",
    "n_pairs": "all pairs: variants times motions",
}
_RESULT: Final = ("demand", "ratio", "lowest", "highest", "n", "n_failed", "n_pairs")
_NAMES: Final = [name for name in CHOICE_COLUMNS if name not in _RESULT]
_JOURNAL: Final = "modelling_choices"


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """Two analyses that differ in one thing.

    Attributes:
        kind: ``choice`` or ``axis``.
        name: The option or the axis.
        from_value: Its configured or lowest value, as text.
        to_value: The other one.
        before: Analysis with the one value.
        after: Analysis with the other.
    """

    kind: str
    name: str
    from_value: str
    to_value: str
    before: Task
    after: Task

    def names(self) -> dict[str, str]:
        """Return what the pair compares, by column."""
        variant = self.before.variant
        return {
            "bridge": variant.bridge_name,
            "abutment": variant.abutment,
            **{name: getattr(self, name) for name in ("kind", "name", "from_value", "to_value")},
        }


def sampled(tasks: Sequence[Task], count: int) -> list[Task]:
    """Return so many analyses of a variant: the middles of equal parts of them, by scaled PGV."""
    ranked = sorted(tasks, key=_strength)
    parts = min(count, len(ranked))
    return [ranked[(2 * part + 1) * len(ranked) // (2 * parts)] for part in range(parts)]


def _strength(task: Task) -> tuple[float, str, float]:
    motion = task.motion
    return motion.measures["im_pgv_rotd50_mps"], motion.motion.motion_id, task.incidence_deg


def choice_pairs(tasks: Sequence[Task], choices: Sequence[Choice] = CHOICES) -> Iterator[Pair]:
    """Yield each analysis with each alternative of each choice that acts on it."""
    for task in tasks:
        for choice in choices:
            configured = value_text(choice.key, choice.configured_in(task))
            for value in choice.alternatives(task):
                yield Pair(
                    kind="choice",
                    name=choice.key,
                    from_value=configured,
                    to_value=value_text(choice.key, value),
                    before=task,
                    after=choice.set_in(task, value),
                )


def axis_pairs(
    setup: StudySetup, slug: str, axes: Mapping[str, Sequence[float]], count: int
) -> Iterator[Pair]:
    """Yield the analyses of a variant at the ends of each axis of the grid that has two values."""
    variant = parse_slug(slug)
    for name, values in axes.items():
        low, high = (end(values, key=abs) for end in (min, max))
        places = [variant.values() | {name: value} for value in (low, high)]
        ends = [Variant.at(variant.bridge, variant.abutment, place) for place in places]
        slugs = [end.normalised().slug for end in ends]
        if slugs[0] == slugs[1]:
            continue  # one value, or an axis that the abutment model does not have
        before, after = (sampled(setup.tasks(slug), count) for slug in slugs)
        texts = {"from_value": value_text(name, low), "to_value": value_text(name, high)}
        for one, other in zip(before, after, strict=True):
            yield Pair(kind="axis", name=name, **texts, before=one, after=other)


def write_choices(
    setup: StudySetup,
    variants: Sequence[str],
    axes: Mapping[str, Sequence[float]],
    *,
    motions: int,
    workers: Workers,
    output: Path,
    digest: str,
) -> None:
    """Run what is missing and write the table of `CHOICE_COLUMNS`.

    What stands in a journal of the study is not run again.

    Args:
        setup: What the variants share.
        variants: Names of the variants to change.
        axes: Values on every axis of the grid, by its name.
        motions: So many of each.
        workers: The worker processes.
        output: Parquet file.
        digest: What the table is made for.
    """
    pairs: list[Pair] = []
    for slug in variants:
        pairs += choice_pairs(sampled(setup.tasks(slug), motions))
        pairs += axis_pairs(setup, slug, axes, motions)
    rows = _run(setup, [task for pair in pairs for task in (pair.before, pair.after)], workers)
    write_frame(choices_table(pairs, rows), output, provenance(made_for=digest))


def choices_table(pairs: Sequence[Pair], rows: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Return the ratios of the demands, one row per compared value and demand.

    Args:
        pairs: What to compare; a pair that is there twice counts once.
        rows: Rows of the demands table by `run_key`.
    """
    keys = {(run_key(pair.before), run_key(pair.after)): pair for pair in pairs}
    table = pd.DataFrame(
        {**pair.names(), "demand": demand, **_compared(rows[before], rows[after], demand)}
        for (before, after), pair in keys.items()
        for demand in demands_for("effect")
    )
    groups = table.groupby([*_NAMES, "demand"], sort=False)
    found = groups.agg(
        ratio=("log", "mean"),
        lowest=("log", "min"),
        highest=("log", "max"),
        n=("log", "count"),
        n_failed=("failed", "sum"),
        n_pairs=("failed", "size"),
    )
    ratios = ["ratio", "lowest", "highest"]
    found[ratios] = np.exp(found[ratios])
    return found.reset_index()[list(CHOICE_COLUMNS)]


def _compared(before: Mapping[str, Any], after: Mapping[str, Any], demand: str) -> dict[str, Any]:
    bottom, top = float(before[demand]), float(after[demand])
    failed = not before["status"] == after["status"] == OK
    usable = not failed and bottom > 0.0 and top > 0.0
    return {"log": np.log(top / bottom) if usable else np.nan, "failed": failed}


def _run(setup: StudySetup, tasks: Iterable[Task], workers: Workers) -> dict[str, dict[str, Any]]:
    once = {run_key(task): task for task in tasks}
    done = read_journals(setup.folder)
    logger.info("%d analyses, %d of them done", len(once), len(once.keys() & done.keys()))
    with open_journal(setup.folder.journal(_JOURNAL)) as journal:
        rows = run_tasks(
            list(once.values()),
            journal,
            done,
            workers=workers,
            log_folder=setup.folder.solver_logs / _JOURNAL,
            on_finished=log_failure,
        )
    return dict(zip(once, rows, strict=True))

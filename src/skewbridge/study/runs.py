"""The analyses of one part of a study, and the tables that the parts make together."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Final

from skewbridge.demands.suspect import SuspectLimits
from skewbridge.demands.tables import write_study
from skewbridge.errors import InputError
from skewbridge.provenance.files import write_text
from skewbridge.study.batch import run_tasks
from skewbridge.study.capacity_search import Known, search_capacity
from skewbridge.study.folder import StudyFolder
from skewbridge.study.guard import Workers
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.plan import Plan, keys_by_variant
from skewbridge.study.progress import StudyProgress, study_state
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import Task
from skewbridge.study.worker import Row, Work

#: How long a part waits for its journal. Where the node of its predecessor was lost, NFSv4 gives
#: the lock free when the lease of that node has ended (90 s unless set otherwise); a node that
#: comes back ends the job.
PREDECESSOR_S: Final = 180.0


def analyse_part(
    folder: StudyFolder, *, number: int, count: int, workers: Workers, output: Path
) -> None:
    """Run what is missing of one part of the planned analyses and write its rows.

    Args:
        folder: Where the study lies, with its plan.
        number: Which part, from 1.
        count: Number of parts.
        workers: The worker processes.
        output: File with the rows of the part, one JSON object a line.

    Raises:
        InputError: Another process analyses this part, or its files cannot be written.
    """
    plan = Plan.read(folder.plan)
    setup = StudySetup.from_sections(plan.sections, folder)
    planned = plan.part(number, count)
    keys = keys_by_variant(planned)
    tasks = {slug: setup.tasks(slug) for slug in keys}
    name = f"analyses_{number}_of_{count}"
    with open_journal(folder.journal(name), PREDECESSOR_S) as journal:
        content = read_content(folder.journals)
        done = content.rows
        with StudyProgress(study_state(keys, content), name, keys) as progress:
            rows = run_tasks(
                [tasks[each.variant][each.number] for each in planned],
                journal,
                done,
                workers=workers,
                log_folder=folder.solver_logs,
                on_finished=progress.advance,
                search=_searching(setup, done, folder.journal(f"{name}_searches")),
            )
    write_text(output, "".join(f"{json.dumps(row)}\n" for row in rows))


def _searching(
    setup: StudySetup, done: Mapping[str, Row], journal: Path
) -> Callable[[Task], Work] | None:
    """Return what makes the search of a task, with the rows of its variant; None but in an IDA."""
    search = setup.search
    if search is None:
        return None
    known: dict[str, dict[str, Row]] = {}
    for key, row in done.items():
        known.setdefault(row["variant"], {})[key] = row

    def of_task(task: Task) -> Work:
        rows = known.get(task.variant.slug, {})
        return partial(search_capacity, search, Known(rows=rows, journal=journal))

    return of_task


def collect_parts(folder: StudyFolder, parts: Iterable[Path], limits: SuspectLimits) -> None:
    """Join the rows of all parts into one table of each variant and one of the study.

    Args:
        folder: Where the study lies, with its plan.
        parts: Files that `analyse_part` wrote.
        limits: What is suspect.

    Raises:
        InputError: Analyses are missing, because the parts are not of this plan.
        ValueError: A row is there twice or does not fit the schema.
    """
    planned = Plan.read(folder.plan).keys()
    # where the rows of each variant stand: all of them at once may be more than the memory holds
    places: dict[str, list[tuple[Path, int]]] = {slug: [] for slug in planned}
    found: dict[str, list[str]] = {slug: [] for slug in planned}
    for part in parts:
        with part.open("rb") as lines:
            start = 0
            for line in lines:
                row = json.loads(line)
                places[row["variant"]].append((part, start))
                found[row["variant"]].append(row["run_key"])
                start += len(line)
    for slug, keys in planned.items():
        if missing := set(keys).difference(found[slug]):
            raise InputError(
                f"{slug}: {len(missing)} of {len(keys)} analyses have no row: the sources were "
                "edited while the study ran; run it again"
            )
    rows_of = ((folder.variant_demands(slug), _rows_at(places[slug])) for slug in sorted(planned))
    run_keys = [key for keys in found.values() for key in keys]
    write_study(rows_of, folder.demands, limits, run_keys)


def _rows_at(places: Sequence[tuple[Path, int]]) -> list[Row]:
    """Return the rows that stand at some places of the parts."""
    rows: list[Row] = []
    for part, own in groupby(places, key=lambda place: place[0]):
        with part.open("rb") as lines:
            for _, start in own:
                lines.seek(start)
                rows.append(json.loads(lines.readline()))
    return rows

"""Analyses of one variant as a job of the workflow, with its journal as the cache."""

import logging
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Final

from skewbridge.demands.suspect import SuspectLimits
from skewbridge.demands.tables import write_variant
from skewbridge.study.batch import Workers, run_tasks
from skewbridge.study.ida import Known, search_capacity
from skewbridge.study.journal import open_journal, read_content
from skewbridge.study.progress import JobProgress
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import Task, run_key
from skewbridge.study.worker import Row, Work

logger = logging.getLogger(__name__)

#: Time that a job waits for the lock of its journal. If the node of the previous job was lost,
#: NFSv4 releases the lock when the lease of that node ends (90 s by default); if the node comes
#: back, the lock stays and this job ends.
PREDECESSOR_S: Final = 180.0


def analyse_variant(
    setup: StudySetup, slug: str, *, workers: Workers, limits: SuspectLimits, output: Path
) -> None:
    """Run the analyses of a variant that its journal does not have, and write its demands.

    Args:
        setup: What the variants of the study share.
        slug: Name of the variant.
        workers: The worker processes.
        limits: Limits above which a row is suspect.
        output: Parquet file of its demands.

    Raises:
        InputError: Another process analyses this variant, or its files cannot be written.
    """
    folder = setup.folder
    tasks = sorted(setup.tasks(slug), key=lambda task: -task.analysed_s)
    keys = [run_key(task) for task in tasks]
    searches = folder.journal(f"{slug}_searches")
    with open_journal(folder.journal(slug), PREDECESSOR_S) as journal:
        content = read_content([journal.path, searches])
        for sentence in content.sentences:
            logger.warning("%s: %s", slug, sentence)
        done = content.rows
        with JobProgress(slug, keys, sum(key in done for key in keys)) as progress:
            rows = run_tasks(
                tasks,
                journal,
                done,
                workers=workers,
                log_folder=folder.solver_logs,
                on_finished=progress.advance,
                search=_searching(setup, done, searches),
            )
    write_variant(rows, output, limits)


def _searching(
    setup: StudySetup, done: Mapping[str, Row], journal: Path
) -> Callable[[Task], Work] | None:
    """Return the function that searches from a task in an IDA; None in other designs."""
    search = setup.search
    if search is None:
        return None
    known = Known(rows=done, journal=journal)
    return lambda _task: partial(search_capacity, search, known)

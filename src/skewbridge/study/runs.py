"""The analyses of a study: their list, and the run of one variant."""

import json
import logging
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from skewbridge.demands.tables import write_demands
from skewbridge.provenance.digests import digest_of
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import provenance
from skewbridge.study.batch import run_tasks
from skewbridge.study.capacity_search import search_capacity
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import open_journal, read_journal
from skewbridge.study.keys import run_key
from skewbridge.study.progress import StudyProgress, study_state
from skewbridge.study.setup import StudySetup

logger = logging.getLogger(__name__)


def write_plan(setup: StudySetup, variants: Sequence[str], path: Path) -> None:
    """Write the keys of all analyses of the study, by variant.

    An IDA does not know its analyses beforehand: its plan has the first one of every search.
    """
    keys = {slug: [run_key(task) for task in setup.tasks(slug)] for slug in variants}
    write_text(path, json.dumps(keys, indent=1))
    state = study_state(keys, setup.folder)
    logger.info(
        "%d variants, %d analyses, %d of them done", state.variants, state.analyses, state.done
    )
    if state.outdated:
        logger.warning(state.outdated_sentence)


def planned_keys(folder: StudyFolder) -> dict[str, list[str]]:
    """Return the keys of all analyses of the study by variant; empty before there is a plan."""
    if not folder.plan.exists():
        return {}
    keys: dict[str, list[str]] = json.loads(folder.plan.read_text(encoding="utf-8"))
    return keys


def analyse_variant(setup: StudySetup, slug: str, *, n_jobs: int, output: Path) -> None:
    """Run what is missing of one variant and write its demands.

    Args:
        setup: What the variants share.
        slug: Name of the variant.
        n_jobs: Worker processes.
        output: Parquet file with the rows of this variant.

    Raises:
        InputError: Another process analyses this variant.
    """
    folder = setup.folder
    tasks = setup.tasks(slug)
    keys = planned_keys(folder) | {slug: [run_key(task) for task in tasks]}
    with (
        open_journal(folder.journal(slug)) as journal,
        StudyProgress(study_state(keys, folder), slug, keys[slug]) as progress,
    ):
        done = read_journal(folder.journal(slug))
        rows = run_tasks(
            tasks,
            journal,
            done,
            n_jobs=n_jobs,
            log_folder=folder.solver_logs,
            on_finished=progress.advance,
            work=partial(search_capacity, setup.search, done) if setup.search else None,
        )
    digest = digest_of(*(row["run_key"] for row in rows))
    write_demands(rows, output, provenance(analyses_digest=digest))

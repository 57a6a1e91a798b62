"""Check of `skewbridge predict` inside the grid: new analyses of variants that the study lacks.

Three variants of each bridge and abutment model lie inside the grid of the study; they are analysed
under some of its motions, and the medians of their own clouds are compared with predicted ones.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import pandas as pd

from skewbridge.demands.completeness import with_derived_columns
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS, prepared
from skewbridge.fragility.limit_states import load_limit_states, with_column_failure
from skewbridge.fragility.predict import CHECK_COLUMNS, check_predict, inner_variants
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.study_tables import write_described
from skewbridge.provenance.tables import read_frame
from skewbridge.study.batch import Workers, run_tasks
from skewbridge.study.journal import open_journal, read_journals
from skewbridge.study.modelling_choices import sampled
from skewbridge.study.progress import log_failure
from skewbridge.study.setup import StudySetup
from skewbridge.variant.variant import Variant

#: Motions of each inner variant.
MOTIONS: Final = 16
_JOURNAL: Final = "check_predict"


def write_predict_check(
    setup: StudySetup,
    axes: Mapping[str, Sequence[float]],
    tables: Mapping[str, Path],
    settings: FitSettings,
    *,
    workers: Workers,
    output: Path,
) -> None:
    """Run the missing analyses of the inner variants and write the table of `CHECK_COLUMNS`.

    Args:
        setup: Motions, options and settings of the study.
        axes: Values on every axis of its grid.
        tables: Files ``demands``, ``joint`` and ``limit_states``.
        settings: Settings of the fits.
        workers: Worker processes.
        output: Parquet file.
    """
    study = read_frame(tables["demands"])
    models = study[list(BRIDGE_COLUMNS)].drop_duplicates().itertuples(index=False)
    slugs = dict.fromkeys(
        Variant.at(str(bridge), str(abutment), place).normalised().slug
        for bridge, abutment in models
        for place in inner_variants(axes)
    )
    tasks = [
        task
        for slug in slugs
        if slug not in set(study["variant"])
        for task in sampled(setup.tasks(slug), MOTIONS)
    ]
    with open_journal(setup.folder.journal(_JOURNAL)) as journal:
        rows = run_tasks(
            tasks,
            journal,
            read_journals(setup.folder),
            workers=workers,
            log_folder=setup.folder.solver_logs / _JOURNAL,
            on_finished=log_failure,
        )
    states = with_column_failure(
        load_limit_states(tables["limit_states"]), with_derived_columns(study.head(0)).columns
    )
    columns = list(dict.fromkeys(state.demand for state in states))
    grid, inner = (prepared(t, columns, settings).table for t in (study, pd.DataFrame(rows)))
    checked = check_predict(read_frame(tables["joint"]), grid, inner, states, settings)
    write_described(checked, output, CHECK_COLUMNS)

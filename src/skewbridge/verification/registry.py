"""The verification studies by name; `skewbridge verify` and the workflow run them from here.

To add a study, write a function in a module of `studies` that takes a `Study` and adds comparisons,
figures and tables to it, then name it in `STUDIES`. The module is imported when the study runs.
"""

import json
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.verification.studies.comparison import COLUMNS, STATEMENT_COLUMNS, Study

# Name of the study (figures as in the paper), module and function.
STUDIES: Final[dict[str, str]] = {
    "gate": "gate:run",
    "fig1": "blocks:run",
    "fig3": "spatial_path:run",
    "fig4": "particle_between_lines:run",
    "fig5-6": "skew_deck:run",
    "fig7-8": "skew_deck:run_tests",
    "bridges": "bridge_hand_values:run",
    "fig10": "bridge_friction:run_abutment",
    "fig11-12": "bridge_friction:run",
    "friction-source": "bridge_friction:run_places",
    "ladder": "bridge_friction:run_models",
    "coupling": "spatial_path:run_orders",
    "closed-forms": "blocks:run_closed_forms",
    "restitution": "blocks:run_integrators",
    "convergence": "strong_motions:run_convergence",
    "native": "native_element:run",
    "hard-set": "strong_motions:run",
}
# Studies of many analyses: they run only when named, and an interrupted one can be resumed.
LONG_STUDIES: Final[dict[str, str]] = {
    "published": "published:run",
    "published-skew": "published:run_skew",
    # parts of the study of convergence
    "convergence-steps": "strong_motions:run_convergence",
    "convergence-mesh": "strong_motions:run_convergence",
    "accuracy": "strong_motions:run_pairs",
    "accuracy-whole": "strong_motions:run_pairs",
}


def run_studies(
    names: Sequence[str], out: Path, *, report_progress: Callable[[str], None] | None = None
) -> list[dict[str, Any]]:
    """Run studies, write their tables and figures, and return all rows.

    The folder gets the comparisons of each study (`<study>.parquet`, `<study>.json`), its figures
    and further tables, all comparisons (`studies.parquet`) and the verdicts on the paper's
    statements (`statements.parquet`). Without names all studies run except the long ones; lines on
    their progress go to `report_progress`.

    Returns:
        The comparisons, then the verdicts with their `outcome`, `reason` and `case`.
    """
    known = STUDIES | LONG_STUDIES
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"unknown study {', '.join(unknown)}; the studies are {', '.join(known)}")
    writable_folder(out)
    rows: list[dict[str, Any]] = []
    statements: list[dict[str, Any]] = []
    for name in names or STUDIES:
        if report_progress:
            report_progress(f"{name} ...")
        try:
            study = run_study(name, out, report_progress)
        except RuntimeError as error:
            # The others still run.
            study = Study(name)
            study.holds(f"the study finishes ({error})", truth=False, source="")
            study.leave_open(f"the study stopped: {error}")
        table = study.table()
        table.to_parquet(out / f"{name}.parquet", index=False)
        text = json.dumps(json.loads(table.to_json(orient="records") or "[]"), indent=1)
        (out / f"{name}.json").write_text(f"{text}\n", encoding="utf-8")
        for label, figure in study.figures.items():
            figure.savefig(out / f"{name}_{label}.svg", metadata={"Date": None})
        for label, extra in study.tables.items():
            extra.to_parquet(out / f"{name}_{label}.parquet", index=False)
        rows += study.rows()
        statements += study.statement_rows()
        # After each study, so that an interrupted run keeps its results.
        pd.DataFrame(rows, columns=list(COLUMNS)).to_parquet(out / "studies.parquet", index=False)
        verdicts = pd.DataFrame(statements, columns=list(STATEMENT_COLUMNS))
        numbers = dict.fromkeys(("value", "reference", "tolerance"), float)
        verdicts.astype(numbers).to_parquet(out / "statements.parquet", index=False)
    return rows + statements


def run_study(
    name: str, kept: Path | None = None, report_progress: Callable[[str], None] | None = None
) -> Study:
    """Run one study; statements without a verdict are undecidable.

    A long study keeps finished analyses in the folder `kept`. `RuntimeError` if a solver fails.
    """
    study = Study(name, kept, report_progress)
    module, function = (STUDIES | LONG_STUDIES)[name].split(":")
    getattr(import_module(f"skewbridge.verification.studies.{module}"), function)(study)
    study.leave_open()
    return study

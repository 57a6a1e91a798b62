"""The verification studies by name; `skewbridge verify` and the workflow run them from here.

To add a study, write a module in `studies` whose function `run` takes a `Study`, compares, and puts
its figures and tables there; then name it in `STUDIES`. It is imported when the study runs.
"""

import json
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder
from skewbridge.verification.studies.comparison import COLUMNS, STATEMENT_COLUMNS, Study

# Name of the study, as the paper numbers its figures, and its module.
STUDIES: Final[dict[str, str]] = {
    "gate": "gate",
    "fig1": "sliding_and_rocking",
    "fig3": "spatial_path",
    "fig4": "particle_between_lines",
    "fig5-6": "pulse_deck",
    "fig7-8": "shake_table_deck",
    "bridges": "bridge_hand_values",
    "fig10": "abutment_friction",
    "fig11-12": "bridge_friction",
    "friction-source": "friction_source",
    "ladder": "abutment_models",
    "coupling": "coupling_order",
    "closed-forms": "oscillators",
    "restitution": "integrator_restitution",
    "convergence": "convergence",
    "native": "native_element",
    "hard-set": "hard_set",
}
# Hours each: they run when they are named, and go on where they were broken off.
LONG_STUDIES: Final[dict[str, str]] = {
    "accuracy": "paired_accuracy",
    "accuracy-whole": "paired_accuracy",
}


def run_studies(
    names: Sequence[str], out: Path, *, tell: Callable[[str], None] | None = None
) -> list[dict[str, Any]]:
    """Run studies, write their tables and figures, and return all rows.

    Without names these are all but the long ones. The folder gets `<study>.parquet`,
    `<study>[_<name>].svg`, further tables, and `<study>.json` with the rows of the comparisons;
    all of these in `studies.parquet`, and what the studies say about the paper's statements in
    `statements.parquet`. The rows returned are the comparisons, then the statements, which have an
    `outcome`, its `reason` and the `case`, too. `tell` is called with one line per study, and now
    and then by a long one.

    Raises:
        InputError: An unknown name, or the folder cannot be made.
    """
    known = STUDIES | LONG_STUDIES
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"unknown study {', '.join(unknown)}; the studies are {', '.join(known)}")
    writable_folder(out)
    rows: list[dict[str, Any]] = []
    statements: list[dict[str, Any]] = []
    for name in names or STUDIES:
        if tell:
            tell(f"{name} ...")
        study = _outcome(name, out, tell)
        _write(study, out)
        rows += study.rows()
        statements += study.statement_rows()
        # After each: a long run that is broken off keeps what it has.
        _write_all(rows, statements, out)
    return rows + statements


def run_study(
    name: str, kept: Path | None = None, tell: Callable[[str], None] | None = None
) -> Study:
    """Run one study; what it leaves open of the paper's statements cannot be told.

    Args:
        name: Of the study.
        kept: Folder where a long study keeps what is finished.
        tell: Called with what it says of its progress.

    Raises:
        RuntimeError: A solver could not finish.
    """
    study = Study(name, kept, tell)
    module = (STUDIES | LONG_STUDIES)[name]
    import_module(f"skewbridge.verification.studies.{module}").run(study)
    study.leave_open()
    return study


def _outcome(name: str, kept: Path, tell: Callable[[str], None] | None) -> Study:
    """Run a study; one that breaks off is a failed comparison, so that the others still run."""
    try:
        return run_study(name, kept, tell)
    except RuntimeError as error:
        failed = Study(name)
        failed.holds(f"the study ends ({error})", truth=False, source="")
        failed.leave_open(f"the study broke off: {error}")
        return failed


def _write_all(
    rows: Sequence[dict[str, Any]], statements: Sequence[dict[str, Any]], out: Path
) -> None:
    """Write the comparisons and the judged statements of all studies so far."""
    pd.DataFrame(rows, columns=list(COLUMNS)).to_parquet(out / "studies.parquet", index=False)
    judged = pd.DataFrame(statements, columns=list(STATEMENT_COLUMNS))
    numbers = dict.fromkeys(("value", "reference", "tolerance"), float)
    judged.astype(numbers).to_parquet(out / "statements.parquet", index=False)


def _write(study: Study, out: Path) -> None:
    """Write what a study found."""
    table = study.table()
    table.to_parquet(out / f"{study.name}.parquet", index=False)
    rows: list[dict[str, Any]] = json.loads(table.to_json(orient="records") or "[]")
    (out / f"{study.name}.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    for label, figure in study.figures.items():
        figure.savefig(out / f"{study.name}_{label}.svg", metadata={"Date": None})
    for label, extra in study.tables.items():
        extra.to_parquet(out / f"{study.name}_{label}.parquet", index=False)

"""The verification studies by name; `skewbridge verify` and the workflow run them from here.

A study is a function without arguments that returns a `StudyResult`. To add one, add its name and
"module:function" to `STUDIES`; the module is imported when the study runs.
"""

import json
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder
from skewbridge.verification.checks import Check, Checklist, StudyResult, table_of

_ROOM: Final = "skewbridge.verification"

STUDIES: Final[dict[str, str]] = {
    "gate": f"{_ROOM}.gate:gate_study",
    "fig1": f"{_ROOM}.figure_1:run",
    "fig3": f"{_ROOM}.figure_3:run",
    "fig4": f"{_ROOM}.figure_4:run",
    "fig5-6": f"{_ROOM}.figure_5_6:run",
    "fig7-8": f"{_ROOM}.figure_7_8:run",
    "bridges": f"{_ROOM}.bridge_hand_values:run",
    "fig10": f"{_ROOM}.abutment_figure_10:run",
    "fig11-12": f"{_ROOM}.bridge_figures_11_12:run",
    "ladder": f"{_ROOM}.bridge_ladder:run",
    "coupling": f"{_ROOM}.coupling_order:run",
    "closed-forms": f"{_ROOM}.closed_form_study:run",
    "restitution": f"{_ROOM}.restitution_study:run",
    "native": f"{_ROOM}.native_element:run",
}


def run_studies(
    names: Sequence[str], out: Path, *, tell: Callable[[str], None] | None = None
) -> list[dict[str, Any]]:
    """Run studies and write their tables and figures.

    Args:
        names: Studies to run; none means all.
        out: Folder for `<study>.parquet`, `<study>[_<name>].svg`, further tables, and
            `<study>.json` with the rows of the checks; all rows together in `studies.parquet`.
        tell: Called with one line per study.

    Returns:
        The rows of all checks.

    Raises:
        InputError: An unknown name, or the folder cannot be made.
    """
    unknown = [name for name in names if name not in STUDIES]
    if unknown:
        raise InputError(
            f"unknown study {', '.join(unknown)}; the studies are {', '.join(STUDIES)}"
        )
    writable_folder(out)
    checks: list[Check] = []
    for name in names or STUDIES:
        if tell:
            tell(f"{name} ...")
        result = _outcome(name)
        write_study(name, result, out)
        checks.extend(result.checks)
    table_of(checks).to_parquet(out / "studies.parquet", index=False)
    return [check.row() for check in checks]


def _outcome(name: str) -> StudyResult:
    """Run a study; one that breaks off is a failed check, so that the others still run."""
    try:
        return load_study(name)()
    except RuntimeError as error:
        checks = Checklist(name)
        checks.holds(f"the study ends ({error})", truth=False, source="")
        return StudyResult(checks=checks.checks)


def load_study(name: str) -> Callable[[], StudyResult]:
    """Return the function of a study."""
    module, function = STUDIES[name].split(":")
    return getattr(import_module(module), function)


def write_study(name: str, result: StudyResult, out: Path) -> None:
    """Write what a study found."""
    table = table_of(result.checks)
    table.to_parquet(out / f"{name}.parquet", index=False)
    rows: list[dict[str, Any]] = json.loads(table.to_json(orient="records") or "[]")
    (out / f"{name}.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    for label, figure in result.figures.items():
        figure.savefig(out / f"{name}_{label}.svg", metadata={"Date": None})
    for label, extra in result.tables.items():
        _write_table(extra, out / f"{name}_{label}.parquet")


def _write_table(table: pd.DataFrame, path: Path) -> None:
    table.to_parquet(path, index=False)

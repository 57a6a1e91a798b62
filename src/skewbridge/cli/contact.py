"""Commands of the contact package: unit process, rigid skew deck, verification studies."""

from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.cli.output import (
    EXIT_FAILED,
    JsonOption,
    clear_errors,
    emit,
    emit_json,
    emit_table,
    messages,
)
from skewbridge.study.folder import StudyFolder

CaseArgument = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="The case file.")]


@clear_errors
def contact(
    case: CaseArgument,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="Forces at the times of the path.")],
    as_json: JsonOption = False,
) -> None:
    """Drive one contact unit along a path of displacements and write its forces."""
    from skewbridge.verification.references.unit_path import run_contact_case

    emit(run_contact_case(case, out), as_json=as_json)


@clear_errors
def deck(
    case: CaseArgument,
    out: Annotated[Path, typer.Option(metavar="F.parquet", help="Histories.")],
    as_json: JsonOption = False,
) -> None:
    """Run the rigid skew deck under a pulse or a record: OpenSees, penalty ODE or LCP."""
    from skewbridge.verification.references.deck import run_deck_case

    emit(run_deck_case(case, out), as_json=as_json)


@clear_errors
def verify(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME...]")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of tables and figures.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Repeat the studies of the paper against their references and judge its statements."""
    from skewbridge.verification.registry import run_studies

    rows = run_studies(names or [], out or StudyFolder().verification, tell=messages.print)
    if as_json:
        emit_json(rows)
    else:
        _show(rows)
    if not all(row["pass"] for row in rows):
        raise typer.Exit(EXIT_FAILED)


def _show(rows: list[dict[str, Any]]) -> None:
    """Print the comparisons, then what the studies say about the paper's statements."""
    checks = [row for row in rows if "outcome" not in row]
    statements = [row for row in rows if "outcome" in row]
    emit_table([{k: v for k, v in row.items() if k != "source"} for row in checks], "Verification")
    if statements:
        columns = ("source", "quantity", "case", "outcome", "reason")
        shown = [{column: row[column] for column in columns} for row in statements]
        emit_table(shown, "Statements of the paper (a disagreement is a result, no failure)")


COMMANDS: Final = (contact, deck, verify)

"""Commands for checks: the environment, contact and deck cases, the paper's studies."""

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from skewbridge.cli.output import (
    Command,
    JsonOption,
    emit,
    emit_json,
    emit_table,
    messages,
    new_group,
)
from skewbridge.errors import EXIT_FAILED

commands = new_group()

CaseArgument = Annotated[Path, typer.Argument(metavar="CASE.yaml", help="The case file.")]


@commands.command(cls=Command)
def doctor(*, as_json: JsonOption = False) -> None:
    """Check the environment: versions, OpenSees, a one-second self-test.

    Example: skewbridge doctor
    """
    import platform
    from importlib.metadata import version

    packages = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "joblib", "snakemake")
    report: dict[str, Any] = {
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }
    began_s = time.perf_counter()
    try:
        from skewbridge.verification.studies.gate import verify_contact_gate

        began_s = time.perf_counter()
        checks = verify_contact_gate()
        failed = [str(name) for name in checks.loc[~checks["pass"], "quantity"]]
        report["self_test"] = f"failed: {', '.join(failed)}" if failed else "passed"
    except ImportError as error:
        failed = ["import"]
        report["self_test"] = f"OpenSees does not import ({error}): run make setup again"
    report["self_test_s"] = round(time.perf_counter() - began_s, 2)
    emit(report | {"ok": not failed}, as_json=as_json)
    if failed:
        raise typer.Exit(EXIT_FAILED)


@commands.command(cls=Command)
def contact(
    case: CaseArgument,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="File for the forces along the path.")],
    as_json: JsonOption = False,
) -> None:
    """Drive one contact unit along a displacement path.

    Example: skewbridge contact slide.yaml --out forces.csv
    """
    from skewbridge.verification.references.driven_unit import run_contact_case

    emit(run_contact_case(case, out), as_json=as_json)


@commands.command(cls=Command)
def deck(
    case: CaseArgument,
    out: Annotated[Path, typer.Option(metavar="F.parquet", help="File for the histories.")],
    as_json: JsonOption = False,
) -> None:
    """Run the rigid skew deck under a pulse or a record.

    The case file chooses the solver: OpenSees, a penalty ODE or an LCP.

    Example: skewbridge deck deck30.yaml --out deck30.parquet
    """
    from skewbridge.verification.references.deck_solvers import run_deck_case

    emit(run_deck_case(case, out), as_json=as_json)


@commands.command(cls=Command)
def verify(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME...]", help="Studies; by default all.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of tables and figures.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Repeat the studies of the paper and compare with their references.

    Exits with 1 if a comparison fails; a statement of the paper that does not hold is a result.

    Example: skewbridge verify fig1 fig3
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.verification.registry import run_studies

    folder = out or StudyFolder().verification
    rows = run_studies(names or [], folder, report_progress=messages.print)
    if as_json:
        emit_json(rows)
    else:
        checks = [
            {name: value for name, value in row.items() if name != "source"}
            for row in rows
            if "outcome" not in row
        ]
        statements = [
            {
                "statement": f"{row['quantity']} ({row['source']})",
                "command": f"skewbridge verify {row['study']}",
                "case": row["case"],
                "number": row["reason"],
                "verdict": row["outcome"],
            }
            for row in rows
            if "outcome" in row
        ]
        emit_table(checks, "Verification")
        if statements:
            emit_table(statements, "Statements of the paper (a disagreement is not a failure)")
    if not all(row["pass"] for row in rows):
        raise typer.Exit(EXIT_FAILED)

"""Commands for checks: the environment, contact and deck cases, the paper's studies."""

import time
from pathlib import Path
from typing import Any, Final

from skewbridge.cli.output import Answer, Arg, Opt, Printed, command, messages, new_group
from skewbridge.errors import EXIT_FAILED

commands = new_group()

_CASE: Final = Arg("case", Path, "The case file.", ..., "CASE.yaml")


@command(commands)
def doctor() -> Answer:
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
    return Answer(report | {"ok": not failed}, exit_code=EXIT_FAILED if failed else 0)


@command(commands, _CASE, Opt("out", Path, "File for the forces along the path.", ..., "F.csv"))
def contact(case: Path, out: Path) -> Answer:
    """Drive one contact unit along a displacement path.

    Example: skewbridge contact slide.yaml --out forces.csv
    """
    from skewbridge.verification.references.driven_unit import run_contact_case

    return Answer(run_contact_case(case, out))


@command(commands, _CASE, Opt("out", Path, "File for the histories.", ..., "F.parquet"))
def deck(case: Path, out: Path) -> Answer:
    """Run the rigid skew deck under a pulse or a record.

    The case file chooses the solver: OpenSees, a penalty ODE or an LCP.

    Example: skewbridge deck deck30.yaml --out deck30.parquet
    """
    from skewbridge.verification.references.deck_solvers import run_deck_case

    return Answer(run_deck_case(case, out))


@command(
    commands,
    Arg("names", list[str] | None, "Studies; by default all.", None, "[NAME...]"),
    Opt("out", Path | None, "Folder of tables and figures."),
)
def verify(names: list[str] | None, out: Path | None) -> Answer:
    """Repeat the studies of the paper and compare with their references.

    Exits with 1 if a comparison fails; a statement of the paper that does not hold is a result.

    Example: skewbridge verify fig1 fig3
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.verification.registry import run_studies

    folder = out or StudyFolder().verification
    rows = run_studies(names or [], folder, report_progress=messages.print)
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
    tables = [Printed(checks, "Verification")]
    if statements:
        title = "Statements of the paper (a disagreement is not a failure)"
        tables.append(Printed(statements, title))
    passed = all(row["pass"] for row in rows)
    return Answer(rows, tables, exit_code=0 if passed else EXIT_FAILED)

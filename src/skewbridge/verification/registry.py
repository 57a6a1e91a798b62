"""The verification studies by name, what each collects, and how they run.

`skewbridge verify` and the workflow run them from here. To add a study, write a function in a
module of `studies` that takes a `Study` and adds comparisons, figures and tables to it, then name
it in `STUDIES`. The module is imported when the study runs.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.text import writable_folder
from skewbridge.verification.statements import STATEMENTS, Run, Verdict, over_runs

if TYPE_CHECKING:  # each workflow runs the gate, which draws nothing
    from matplotlib.figure import Figure

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

COLUMNS: Final = ("study", "quantity", "value", "reference", "tolerance", "pass", "source")
# Runs that judge a case: the record at several scales and other motions, and how many agree.
RUN_COLUMNS: Final = ("scales", "scales_agree", "motions", "motions_agree")
STATEMENT_COLUMNS: Final = (*COLUMNS, "case", "outcome", "reason", *RUN_COLUMNS)
# Source of references that show whether the model changed, not whether it is right.
EARLIER_MODEL: Final = "this project's earlier model (regression only)"


@dataclass(frozen=True, slots=True)
class ReferenceCheck:
    """A computed quantity compared with its reference.

    The tolerance is the largest absolute difference; None: reported, not judged.
    """

    quantity: str
    value: float
    reference: float
    tolerance: float | None
    source: str

    @property
    def is_passed(self) -> bool:
        """Whether the difference is within the tolerance; a row without tolerance passes."""
        if self.tolerance is None:
            return True
        return isfinite(self.value) and abs(self.value - self.reference) <= self.tolerance


class StatementCase(NamedTuple):
    """Verdict on a statement of the paper in one case, from all its runs."""

    statement: str
    case: str
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class Study:
    """Collects the results of a study: comparisons, verdicts on statements, figures, tables.

    A long study keeps finished analyses in the folder `kept` and logs its progress by
    `report_progress`, line by line.
    """

    name: str
    kept: Path | None = None
    report_progress: Callable[[str], None] | None = None
    comparisons: list[ReferenceCheck] = field(default_factory=list[ReferenceCheck])
    verdicts: list[StatementCase] = field(default_factory=list[StatementCase])
    runs: dict[tuple[str, str], dict[Run, Verdict | None]] = field(
        default_factory=dict[tuple[str, str], dict[Run, Verdict | None]]
    )
    figures: "dict[str, Figure]" = field(default_factory=dict)
    tables: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])

    def relative(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare with a tolerance relative to the reference; without one, only report."""
        limit = None if tolerance is None else tolerance * abs(reference)
        self.absolute(quantity, value, reference, limit, source)

    def absolute(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare with an absolute tolerance; without one, only report."""
        check = ReferenceCheck(quantity, float(value), float(reference), tolerance, source)
        self.comparisons.append(check)

    def at_most(self, quantity: str, value: float, limit: float, source: str) -> None:
        """Compare a quantity that is not negative with zero."""
        self.absolute(quantity, value, 0.0, limit, source)

    def holds(self, quantity: str, *, truth: bool, source: str) -> None:
        """Add a condition that is true (1) or false (0)."""
        self.absolute(quantity, truth, 1.0, 0.0, source)

    def report(self, quantity: str, value: float, reference: float, source: str) -> None:
        """Report two numbers without judging them."""
        self.absolute(quantity, value, reference, None, source)

    def states(
        self,
        statement: str,
        case: str,
        *numbers: Any,
        run: Run | None = None,
        premise: bool = True,
        **conditions: bool,
    ) -> None:
        """Add the verdict on a statement (a row of the table) in one case, from its numbers.

        `leave_open` joins the verdicts of several runs of a case; one that does not meet the
        premise of the statement does not count.
        """
        verdict = STATEMENTS[statement].verdict(*numbers, **conditions)
        if run is None:
            self.verdicts.append(StatementCase(statement, case, verdict))
        else:
            self.runs.setdefault((statement, case), {})[run] = verdict if premise else None

    def leave_open(self, reason: str = "") -> None:
        """Join the runs of each case; a statement of this study without a verdict stays open."""
        self.verdicts.extend(
            StatementCase(*key, over_runs(runs)) for key, runs in self.runs.items()
        )
        self.runs.clear()
        judged = {found.statement for found in self.verdicts}
        for key, statement in STATEMENTS.items():
            if statement.study == self.name and key not in judged:
                verdict = Verdict("undecidable", statement.open_because or reason)
                self.verdicts.append(StatementCase(key, "", verdict))

    def rows(self) -> list[dict[str, Any]]:
        """Return one row per comparison, with the columns of the `verify` command."""
        return [
            {
                "study": self.name,
                "quantity": found.quantity,
                "value": found.value,
                "reference": found.reference,
                "tolerance": found.tolerance,
                "pass": found.is_passed,
                "source": found.source,
            }
            for found in self.comparisons
        ]

    def statement_rows(self) -> list[dict[str, Any]]:
        """Return one row per verdict; no verdict fails the study."""
        return [
            {
                "study": self.name,
                "quantity": STATEMENTS[statement].claim,
                "value": verdict.value,
                "reference": verdict.reference,
                "tolerance": None,
                "pass": True,
                "source": f"paper, {STATEMENTS[statement].place}",
                "case": case,
                "outcome": verdict.outcome,
                "reason": verdict.reason,
                **dict(zip(RUN_COLUMNS, verdict.scales + verdict.motions, strict=True)),
            }
            for statement, case, verdict in self.verdicts
        ]

    def table(self) -> pd.DataFrame:
        """Return the rows as a table."""
        return pd.DataFrame(self.rows(), columns=list(COLUMNS))


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

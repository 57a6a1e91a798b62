"""What a study finds: values beside their references, the paper's statements, figures, tables."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any, Final

import pandas as pd
from matplotlib.figure import Figure

from skewbridge.verification.judgement import Judgement, cannot_be_told
from skewbridge.verification.paper import STATEMENTS, statements_of

COLUMNS: Final = ("study", "quantity", "value", "reference", "tolerance", "pass", "source")
STATEMENT_COLUMNS: Final = (*COLUMNS, "case", "outcome", "reason")
# Sources of references that tell whether the model changed, not whether it is right.
EARLIER_MODEL: Final = "this project's earlier model (regression only)"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A quantity beside its reference.

    Attributes:
        quantity: What is compared, with its unit.
        value: Computed here.
        reference: What it is compared with.
        tolerance: Largest allowed absolute difference; None: reported, not asserted.
        source: Where the reference is from.
    """

    quantity: str
    value: float
    reference: float
    tolerance: float | None
    source: str

    @property
    def is_passed(self) -> bool:
        """Whether the difference is within the tolerance; what is only reported passes."""
        if self.tolerance is None:
            return True
        return isfinite(self.value) and abs(self.value - self.reference) <= self.tolerance


@dataclass(frozen=True, slots=True)
class Finding:
    """A statement of the paper judged in one case, both by name."""

    statement: str
    case: str
    judgement: Judgement


@dataclass(frozen=True, slots=True)
class Study:
    """Collects what a study finds: comparisons and judged statements so far, figures, tables.

    Attributes:
        kept: Folder where a long study keeps what is finished; None keeps nothing.
    """

    name: str
    kept: Path | None = None
    comparisons: list[Comparison] = field(default_factory=list[Comparison])
    findings: list[Finding] = field(default_factory=list[Finding])
    figures: dict[str, Figure] = field(default_factory=dict[str, Figure])
    tables: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])

    def relative(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare with a tolerance relative to the reference; without one, only report."""
        limit = None if tolerance is None else tolerance * abs(reference)
        self.absolute(quantity, value, reference, limit, source)

    def relative_each(
        self,
        quantity: str,
        values: Mapping[str, float],
        references: Mapping[str, tuple[float, float]],
        source: str,
    ) -> None:
        """Compare values by name, each with its reference and relative tolerance.

        The name follows the quantity, such as "case C1: peak"; values without a reference are left.
        """
        for name, (reference, tolerance) in references.items():
            self.relative(f"{quantity} {name}", values[name], reference, tolerance, source)

    def absolute(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare with an absolute tolerance; without one, only report."""
        found = Comparison(quantity, float(value), float(reference), tolerance, source)
        self.comparisons.append(found)

    def at_most(self, quantity: str, value: float, limit: float, source: str) -> None:
        """Compare a quantity that is not negative with zero."""
        self.absolute(quantity, value, 0.0, limit, source)

    def holds(self, quantity: str, *, truth: bool, source: str) -> None:
        """Add a condition that is true (1) or false (0)."""
        self.absolute(quantity, truth, 1.0, 0.0, source)

    def report(self, quantity: str, value: float, reference: float, source: str) -> None:
        """Report two numbers side by side without judging."""
        self.absolute(quantity, value, reference, None, source)

    def states(self, statement: str, case: str, judgement: Judgement) -> None:
        """Add what the study says about a statement of the paper in one case.

        Raises:
            KeyError: The table of statements does not have it.
        """
        if statement not in STATEMENTS:
            raise KeyError(statement)
        self.findings.append(Finding(statement, case, judgement))

    def leave_open(self, reason: str = "") -> None:
        """Add the statements that the study had to judge and did not, with the reason."""
        judged = {found.statement for found in self.findings}
        for key, statement in statements_of(self.name).items():
            if key not in judged:
                self.states(key, "", cannot_be_told(statement.open_because or reason))

    def statement_rows(self) -> list[dict[str, Any]]:
        """Return one row per judged statement; none of them fails the study."""
        return [
            {
                "study": self.name,
                "quantity": STATEMENTS[found.statement].claim,
                "value": found.judgement.value,
                "reference": found.judgement.reference,
                "tolerance": None,
                "pass": True,
                "source": f"paper, {STATEMENTS[found.statement].place}",
                "case": found.case,
                "outcome": found.judgement.outcome,
                "reason": found.judgement.reason,
            }
            for found in self.findings
        ]

    def rows(self) -> list[dict[str, str | float | bool | None]]:
        """Return one row per comparison, with the columns of the `verify` command."""
        cells = [
            {"study": self.name, "pass": found.is_passed, **asdict(found)}
            for found in self.comparisons
        ]
        return [{column: row[column] for column in COLUMNS} for row in cells]

    def table(self) -> pd.DataFrame:
        """Return the rows as a table."""
        return pd.DataFrame(self.rows(), columns=list(COLUMNS))

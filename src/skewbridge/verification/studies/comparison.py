"""One row of a verification table: a value, its reference, the tolerance and where it is from."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite

import pandas as pd
from matplotlib.figure import Figure

COLUMNS = ("study", "quantity", "value", "reference", "tolerance", "pass", "source")


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """A compared quantity.

    Attributes:
        study: Name of the study.
        quantity: What is compared, with its unit.
        value: Computed here.
        reference: What it is compared with.
        tolerance: Largest allowed absolute difference; None: reported, not asserted.
        source: Where the reference is from.
    """

    study: str
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

    def row(self) -> dict[str, str | float | bool | None]:
        """Return the row of the table."""
        return {
            "study": self.study,
            "quantity": self.quantity,
            "value": self.value,
            "reference": self.reference,
            "tolerance": self.tolerance,
            "pass": self.is_passed,
            "source": self.source,
        }


@dataclass(frozen=True, slots=True)
class Checklist:
    """Collects the checks of one study.

    Attributes:
        study: Name of the study.
        checks: What has been compared so far.
    """

    study: str
    checks: list[Check] = field(default_factory=list[Check])

    def relative(
        self, quantity: str, value: float, reference: float, tolerance: float, source: str
    ) -> None:
        """Compare with a tolerance relative to the reference."""
        self.absolute(quantity, value, reference, tolerance * abs(reference), source)

    def absolute(
        self, quantity: str, value: float, reference: float, tolerance: float, source: str
    ) -> None:
        """Compare with an absolute tolerance."""
        self._add(quantity, value, reference, tolerance, source)

    def at_most(self, quantity: str, value: float, limit: float, source: str) -> None:
        """Compare a quantity that is not negative with zero."""
        self._add(quantity, value, 0.0, limit, source)

    def holds(self, quantity: str, *, truth: bool, source: str) -> None:
        """Add a statement that is true (1) or false (0)."""
        self._add(quantity, float(truth), 1.0, 0.0, source)

    def report(self, quantity: str, value: float, reference: float, source: str) -> None:
        """Report two numbers side by side without judging."""
        self._add(quantity, value, reference, None, source)

    def _add(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        self.checks.append(
            Check(
                study=self.study,
                quantity=quantity,
                value=float(value),
                reference=float(reference),
                tolerance=tolerance,
                source=source,
            )
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult:
    """Outcome of a study.

    Attributes:
        checks: The compared quantities.
        figures: Figures by name.
        tables: Further tables by name.
    """

    checks: Sequence[Check]
    figures: dict[str, Figure] = field(default_factory=dict[str, Figure])
    tables: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])


def table_of(checks: Sequence[Check]) -> pd.DataFrame:
    """Return the checks as a table with the columns of the `verify` command."""
    return pd.DataFrame([check.row() for check in checks], columns=list(COLUMNS))

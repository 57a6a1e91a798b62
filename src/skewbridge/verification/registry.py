"""Registry and runner of the verification studies, and the container of their results.

`skewbridge verify` and the workflow run the studies from here. To add a study, write a function in
a module of `studies` that takes a `Study` and adds comparisons, figures and tables to it, then add
it to `STUDIES`. The module is imported when the study runs.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import ceil, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.files.tables import Row
from skewbridge.files.text import read_mapping, writable_folder
from skewbridge.verification.statements import STATEMENTS, Run, Verdict, over_runs, records_in

if TYPE_CHECKING:  # every workflow runs the contact checks (gate), which need no figures
    from matplotlib.figure import Figure

_FOLDER: Final = Path(__file__).parent
#: Module and function of each study, keyed by name; the long ones run only when named.
STUDIES, LONG_STUDIES = read_mapping(_FOLDER / "studies.yaml").values()

COLUMNS: Final = ("study", "quantity", "value", "reference", "tolerance", "pass", "source")
# Number of runs of a case (scales of the record, other motions), and how many of them agree.
RUN_COLUMNS: Final = ("scales", "scales_agree", "motions", "motions_agree")
STATEMENT_COLUMNS: Final = (*COLUMNS, "case", "outcome", "reason", *RUN_COLUMNS)

type Runs = dict[Run | None, Verdict | None]

#: References that no study computes: rows of `reference_values.csv`, keyed by study and quantity. A
#: tolerance in % is relative to the reference; without a tolerance a value is only reported.
TABULATED: Final[dict[tuple[str, str], dict[str, str]]] = {
    (row["study"], row["quantity"]): row for row in records_in(_FOLDER / "reference_values.csv")
}


def _ignore(_line: str) -> None:
    pass


@dataclass(frozen=True, slots=True)
class Study:
    """Results of a study: comparisons, verdicts on statements, figures and tables.

    A comparison is a row with the columns of the `verify` command. `runs` maps statement and case
    to the verdict of each run; a verdict that is not from a run has the key None. A long study
    keeps finished analyses in the folder `kept` and sends progress lines to `report_progress`. A
    study of recordings reads them from the folder `records`; without it, it does nothing.
    """

    name: str
    kept: Path = Path()
    report_progress: Callable[[str], None] = _ignore
    records: Path | None = None
    comparisons: list[Row] = field(default_factory=list[Row])
    runs: dict[tuple[str, str], Runs] = field(default_factory=dict[tuple[str, str], Runs])
    figures: "dict[str, Figure]" = field(default_factory=dict)
    tables: dict[str, pd.DataFrame] = field(default_factory=dict[str, pd.DataFrame])

    def absolute(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare a value with a reference; without an absolute tolerance, only report both."""
        value, reference = float(value), float(reference)
        passed = tolerance is None or (isfinite(value) and abs(value - reference) <= tolerance)
        row = (self.name, quantity, value, reference, tolerance, passed, source)
        self.comparisons.append(dict(zip(COLUMNS, row, strict=True)))

    def relative(
        self, quantity: str, value: float, reference: float, tolerance: float | None, source: str
    ) -> None:
        """Compare a value with a reference; the tolerance (or None) is a fraction of it."""
        limit = None if tolerance is None else tolerance * abs(reference)
        self.absolute(quantity, value, reference, limit, source)

    def tabulated(self, quantity: str, value: float) -> None:
        """Compare a value with its reference in `reference_values.csv`."""
        row = TABULATED[self.name, quantity]
        number, percent, _ = row["tolerance"].partition("%")
        tolerance = float(number) / (100.0 if percent else 1.0) if number else None
        compare = self.relative if percent else self.absolute
        compare(quantity, value, float(row["reference"]), tolerance, row["source"])

    def at_most(self, quantity: str, value: float, limit: float, source: str) -> None:
        """Require that a non-negative quantity is at most a limit."""
        self.absolute(quantity, value, 0.0, limit, source)

    def holds(self, quantity: str, *, truth: bool, source: str) -> None:
        """Require a condition; its value is 1 (true) or 0 (false)."""
        self.absolute(quantity, truth, 1.0, 0.0, source)

    def report(self, quantity: str, value: float, reference: float, source: str) -> None:
        """Report a value and its reference without pass or fail."""
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
        """Add the verdict on a statement (a row of `statements.csv`) from the numbers of one case.

        Verdicts of several runs are combined; one that does not meet the premise does not count.
        """
        verdict = STATEMENTS[statement].verdict(*numbers, **conditions)
        self.runs.setdefault((statement, case), {})[run] = verdict if premise else None

    def statement_rows(self, open_because: str = "") -> list[Row]:
        """Return one row per statement and case; a verdict never fails the study.

        Without a case the statement is undecidable, for the reason of its row or `open_because`.
        """
        verdicts = {key: over_runs(runs) for key, runs in self.runs.items()}
        with_verdict = {statement for statement, _ in verdicts}
        for key, row in STATEMENTS.items():
            if row.study == self.name and key not in with_verdict:
                verdicts[key, ""] = Verdict("undecidable", row.open_because or open_because)
        rows: list[Row] = []
        for (key, case), verdict in verdicts.items():
            claim, source = STATEMENTS[key].claim, f"paper, {STATEMENTS[key].place}"
            numbers = verdict.value, verdict.reference, None, True
            judgement = case, verdict.outcome, verdict.reason, *verdict.scales, *verdict.motions
            row = (self.name, claim, *numbers, source, *judgement)
            rows.append(dict(zip(STATEMENT_COLUMNS, row, strict=True)))
        return rows

    def table(self) -> pd.DataFrame:
        """Return the comparisons as a table."""
        return pd.DataFrame(self.comparisons, columns=list(COLUMNS))


class Panel(NamedTuple):
    """A panel of a figure, with axis labels and lines (see `drawn`) keyed by name."""

    x: str
    y: str
    lines: Mapping[str, Any]
    title: str = ""
    options: Mapping[str, Any] = {}  # properties of the axes, such as their scale


def drawn(
    panels: Sequence[Panel], *, columns: int = 1, height_in: float, title: str = ""
) -> "Figure":
    """Return a figure of panels, filled row by row.

    A line is (x, y) or (x, y, matplotlib keywords); names that start with an underscore have no
    legend.
    """
    from matplotlib import style as styles
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(name for panel in panels for name in panel.lines))
    # the style of the report would make checks of contact depend on its tables
    with styles.context(_FOLDER / "figures.mplstyle"):
        figure = Figure(figsize=(7.2, height_in), layout="constrained")
        axes = figure.subplots(ceil(len(panels) / columns), columns, squeeze=False)
        in_legend: dict[str, Any] = {}
        for axis, panel in zip(axes.flat, panels, strict=True):
            for name, (x, y, *styles) in panel.lines.items():
                number = names.index(name)  # the first line is wide, to be visible below the others
                style = {"color": f"C{number}", "lw": 0.9 if number else 1.8}
                (line,) = axis.plot(x, y, **style | (styles[0] if styles else {}))
                if not name.startswith("_"):
                    in_legend[name] = line
            axis.set(xlabel=panel.x, ylabel=panel.y, title=panel.title, **panel.options)
        if len(in_legend) > 1:
            columns = min(len(in_legend), 4)
            figure.legend(in_legend.values(), in_legend, loc="outside upper center", ncols=columns)
        figure.suptitle(title)
    return figure


def run_studies(
    names: Sequence[str],
    out: Path,
    *,
    report_progress: Callable[[str], None] = _ignore,
    records: Path | None = None,
) -> list[Row]:
    """Run studies (by default all but the long ones), write tables and figures, return all rows.

    Comparisons are in `<study>.parquet` and .json and `studies.parquet`, verdicts on the paper's
    statements (rows with `outcome`, `reason`, `case`) in `statements.parquet`.
    """
    studies = STUDIES | LONG_STUDIES
    unknown = [name for name in names if name not in studies]
    if unknown:
        raise InputError(f"unknown study {', '.join(unknown)}; choose from {', '.join(studies)}")
    writable_folder(out)
    rows: list[Row] = []
    statements: list[Row] = []
    for name in names or STUDIES:
        report_progress(f"{name} ...")
        stopped = ""
        try:
            study = run_study(name, out, report_progress, records)
        except RuntimeError as error:
            # The remaining studies still run.
            study, stopped = Study(name), f"the study stopped: {error}"
            study.holds(f"the study finishes ({error})", truth=False, source="")
        table = study.table()
        table.to_json(out / f"{name}.json", orient="records", indent=1, double_precision=15)
        for label, figure in study.figures.items():
            figure.savefig(out / f"{name}_{label}.svg", metadata={"Date": None})
        for label, extra in {"": table, **{f"_{k}": t for k, t in study.tables.items()}}.items():
            extra.to_parquet(out / f"{name}{label}.parquet", index=False)
        rows += study.comparisons
        statements += study.statement_rows(stopped)
        # Write after each study, so that an interrupted run keeps its results.
        pd.DataFrame(rows, columns=list(COLUMNS)).to_parquet(out / "studies.parquet", index=False)
        verdicts = pd.DataFrame(statements, columns=list(STATEMENT_COLUMNS))
        numbers = dict.fromkeys(("value", "reference", "tolerance"), float)
        verdicts.astype(numbers).to_parquet(out / "statements.parquet", index=False)
    return rows + statements


def run_study(
    name: str,
    kept: Path = Path(),
    report_progress: Callable[[str], None] = _ignore,
    records: Path | None = None,
) -> Study:
    """Run a study; a long one keeps its analyses in `kept`. A solver raises `RuntimeError`."""
    study = Study(name, kept, report_progress, records)
    module, function = (STUDIES | LONG_STUDIES)[name].split(":")
    getattr(import_module(f"skewbridge.verification.studies.{module}"), function)(study)
    return study

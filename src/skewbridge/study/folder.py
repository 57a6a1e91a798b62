"""Where everything of a study lies: one folder, named by the key `results` of its configuration."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

DEFAULT_ROOT: Final = "results"


@dataclass(frozen=True, slots=True)
class StudyFolder:
    """The paths of a study.

    Attributes:
        root: The folder.
    """

    root: Path = Path(DEFAULT_ROOT)

    @property
    def plan(self) -> Path:
        """Keys of all analyses, by variant."""
        return self.root / "plan.json"

    @property
    def suite(self) -> Path:
        """The motions with their factors."""
        return self.root / "motions" / "suite.parquet"

    @property
    def intensities(self) -> Path:
        """Intensity measures at factor 1, by bridge and motion."""
        return self.root / "motions" / "intensities.parquet"

    @property
    def motions_digest(self) -> Path:
        """What the files of the motions say, kept so that they are read again only if touched."""
        return self.root / "motions" / "digest.json"

    @property
    def journals(self) -> Path:
        """Folder of the journals."""
        return self.root / "journal"

    def journal(self, name: str) -> Path:
        """Return the finished analyses of a variant, or of another rule that runs analyses."""
        return self.journals / f"{name}.jsonl"

    def variant_demands(self, variant: str) -> Path:
        """Return the demands of one variant."""
        return self.root / "demands" / f"{variant}.parquet"

    @property
    def demands(self) -> Path:
        """The demands of all variants."""
        return self.root / "demands.parquet"

    @property
    def sensitivity(self) -> Path:
        """Ratios of the demands to those at the default penalties and step."""
        return self.root / "sensitivity.parquet"

    @property
    def friction_pair(self) -> Path:
        """Histories of a bridge without and with friction."""
        return self.root / "friction_pair.parquet"

    def fragility(self, table: str) -> Path:
        """Return a table of the fits."""
        return self.root / "fragility" / f"{table}.parquet"

    @property
    def verification(self) -> Path:
        """Folder of the checks against independent references."""
        return self.root / "verification"

    @property
    def gate(self) -> Path:
        """Checks of the contact law before anything is analysed."""
        return self.verification / "contact_gate.parquet"

    @property
    def figures(self) -> Path:
        """Folder of the figures."""
        return self.root / "figures"

    @property
    def captions(self) -> Path:
        """What the report says of the figures, written when all are drawn."""
        return self.root / "captions.json"

    @property
    def checks(self) -> Path:
        """Checks of the tables."""
        return self.root / "checks.json"

    @property
    def report(self) -> Path:
        """The page that joins tables and figures."""
        return self.root / "report.html"

    @property
    def solver_logs(self) -> Path:
        """Folder of the solver's messages."""
        return self.root / "logs" / "solver"

    def log(self, rule: str) -> Path:
        """Return the log of a rule."""
        return self.root / "logs" / f"{rule}.log"

    def benchmark(self, job: str) -> Path:
        """Return where Snakemake writes the cost of a job."""
        return self.root / "benchmarks" / f"{job}.tsv"

"""Where everything of a study lies: one folder, named by the key `results` of its configuration."""

from pathlib import Path
from typing import Final

DEFAULT_ROOT: Final = "results"


class StudyFolder:
    """The paths of a study.

    Args:
        root: The folder.
    """

    def __init__(self, root: Path = Path(DEFAULT_ROOT)) -> None:
        self.root: Final = root
        #: The list of all analyses.
        self.plan: Final = root / "plan.json"
        #: The motions with their factors.
        self.suite: Final = root / "motions" / "suite.parquet"
        #: Intensity measures at factor 1, by bridge and motion.
        self.intensities: Final = root / "motions" / "intensities.parquet"
        #: What the files of the motions say, kept so that they are read again only if touched.
        self.motions_digest: Final = root / "motions" / "digest.json"
        #: The demands of all variants.
        self.demands: Final = root / "demands.parquet"
        #: Ratios of the demands to those at the default penalties and step.
        self.sensitivity: Final = root / "sensitivity.parquet"
        #: Demands under other choices of the modeller, over those of the configured model.
        self.modelling_choices: Final = root / "modelling_choices.parquet"
        #: Histories of a bridge without and with friction.
        self.friction_pair: Final = root / "friction_pair.parquet"
        #: Folder of the checks against independent references.
        self.verification: Final = root / "verification"
        #: Checks of the contact law before anything is analysed.
        self.gate: Final = self.verification / "contact_gate.parquet"
        #: Folder of the figures.
        self.figures: Final = root / "figures"
        #: What the report says of the figures, written when all are drawn.
        self.captions: Final = root / "captions.json"
        #: Checks of the tables.
        self.checks: Final = root / "checks.json"
        #: The page that joins tables and figures.
        self.report: Final = root / "report.html"
        #: Folder of the solver's messages.
        self.solver_logs: Final = root / "logs" / "solver"

    def journal(self, name: str) -> Path:
        """Return the finished analyses of one job: a part of the study, or another rule."""
        return self.root / "journal" / f"{name}.jsonl"

    @property
    def journals(self) -> list[Path]:
        """The journals of all jobs so far, of earlier studies in this folder, too."""
        return sorted(self.root.glob("journal/*.jsonl"))

    def part(self, number: int | str, count: int | str) -> Path:
        """Return the rows of one of so many parts of the study, kept until they are joined."""
        return self.root / "demands" / "parts" / f"{number}_of_{count}.jsonl"

    def made_parts(self) -> list[Path]:
        """Return the parts of the study that are there, of one cut and complete; else none."""
        cuts: dict[int, dict[int, Path]] = {}
        any_part = self.part("*", "*")
        for path in any_part.parent.glob(any_part.name):
            number, count = map(int, path.stem.split("_of_"))
            cuts.setdefault(count, {})[number] = path
        complete = [cut for count, cut in cuts.items() if len(cut) == count]
        return [path for _, path in sorted(complete[0].items())] if complete else []

    def variant_demands(self, variant: str) -> Path:
        """Return the demands of one variant."""
        return self.root / "demands" / f"{variant}.parquet"

    def fragility(self, table: str, ending: str = "parquet") -> Path:
        """Return a table of the fits."""
        return self.root / "fragility" / f"{table}.{ending}"

    def log(self, rule: str) -> Path:
        """Return the log of a rule."""
        return self.root / "logs" / f"{rule}.log"

    def benchmark(self, job: str) -> Path:
        """Return where Snakemake writes the cost of a job."""
        return self.root / "benchmarks" / f"{job}.tsv"

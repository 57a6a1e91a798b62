"""Files of a study: paths of its results, and the starter files of a new study."""

import shutil
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.files.digests import PACKAGE

DEFAULT_ROOT: Final = "results"
#: Paths as in a clone; pyproject.toml installs the same files next to the package.
STARTER_PARTS: Final = (
    "Snakefile",
    "workflow/Snakefile",
    "workflow/rules",
    "workflow/scripts",
    "workflow/report",
    "workflow/profiles",
    "profiles",
    "config",
    "motions/README.md",
    "motions/index.csv",
    "motions/synthetic",
    "motions/far",
    "motions/pulse",
)
_LEFT_OUT: Final = shutil.ignore_patterns("__pycache__", ".*")


def default_root(configuration: str | Path) -> str:
    """Return the folder of a study whose configuration does not name it.

    It is `results/NAME` for `config/NAME.yaml`, so that a copy of a configuration has its own
    folder, and `results` otherwise.
    """
    path = Path(configuration).resolve()
    is_named = path.parent.name == "config" and path.stem != "config"
    return f"{DEFAULT_ROOT}/{path.stem}" if is_named else DEFAULT_ROOT


class StudyFolder:
    """The paths of a study below its folder."""

    def __init__(self, root: Path = Path(DEFAULT_ROOT)) -> None:
        self.root: Final = root
        #: The motions with their factors.
        self.suite: Final = root / "motions" / "suite.parquet"
        #: Intensity measures at factor 1, by bridge and motion.
        self.intensities: Final = root / "motions" / "intensities.parquet"
        #: Digests of the motion files, so that a file is read again only if it was touched.
        self.motions_digest: Final = root / "motions" / "digest.json"
        #: The demands of all variants.
        self.demands: Final = root / "demands.parquet"
        #: Headline effects after every round of a study that runs until they are decided.
        self.rounds: Final = root / "rounds.parquet"
        #: Ratios of the demands to those at the default penalties and step.
        self.sensitivity: Final = root / "sensitivity.parquet"
        #: Demands under other choices of the modeller, over those of the configured model.
        self.modelling_choices: Final = root / "modelling_choices.parquet"
        #: Histories of a bridge without and with friction.
        self.friction_pair: Final = root / "friction_pair.parquet"
        #: Folder of the verification against independent references.
        self.verification: Final = root / "verification"
        #: Checks of the contact law before anything is analysed.
        self.contact_checks: Final = self.verification / "contact_checks.parquet"
        #: Folder of the figures.
        self.figures: Final = root / "figures"
        #: Captions of the figures, written when all are drawn.
        self.captions: Final = root / "captions.json"
        #: Checks of the tables.
        self.checks: Final = root / "checks.json"
        #: The page that joins tables and figures.
        self.report: Final = root / "report.html"
        #: Folder of the solver's messages.
        self.solver_logs: Final = root / "logs" / "solver"

    def journal(self, name: str) -> Path:
        """Return the journal of one job: the analyses of a variant, or of another rule."""
        return self.root / "journal" / f"{name}.jsonl"

    @property
    def journals(self) -> list[Path]:
        """The journals of all jobs so far, including those of earlier studies in this folder."""
        return sorted(self.root.glob("journal/*.jsonl"))

    def variant_demands(self, variant: str) -> Path:
        """Return the demands of one variant."""
        return self.root / "demands" / f"{variant}.parquet"

    def round(self, number: int | str) -> Path:
        """Return the plan of a round."""
        return self.root / "rounds" / f"round{number}.json"

    def round_demands(self, number: int | str, variant: str) -> Path:
        """Return the demands of one variant in a round."""
        return self.root / "demands" / f"round{number}" / f"{variant}.parquet"

    def fragility(self, table: str, ending: str = "parquet") -> Path:
        """Return a table of the fits."""
        return self.root / "fragility" / f"{table}.{ending}"

    @property
    def report_inputs(self) -> dict[str, Path]:
        """The files that the page is made from, by name; the figures are in their own folder."""
        fits = ("curves", "effects", "needed_motions", "intensity_effects", "input_notes", "suites")
        return {
            **{name: getattr(self, name) for name in ("captions", "demands", "suite")},
            **{name: getattr(self, name) for name in ("contact_checks", "checks", "sensitivity")},
            **{name: self.fragility(name) for name in (*fits, "system", "measures", "joint")},
            "medians": self.fragility("median_effects"),
        }

    def log(self, rule: str) -> Path:
        """Return the log of a rule."""
        return self.root / "logs" / f"{rule}.log"

    def benchmark(self, job: str) -> Path:
        """Return the file in which Snakemake writes the cost of a job."""
        return self.root / "benchmarks" / f"{job}.tsv"


def starter_files(package: Path = PACKAGE) -> Path:
    """Return the folder of the files: next to an installed package, or the root of a clone."""
    for folder in (package.parent / "skewbridge_starter", package.parents[1]):
        if all((folder / part).exists() for part in STARTER_PARTS):
            return folder
    raise InputError(
        f"the starter files of a study are not next to {package}: install the package again"
    )


def write_starter(folder: Path) -> list[Path]:
    """Write the files of a study into a folder, and return the files and folders written.

    Raises:
        InputError: One of the files exists already; nothing is written then.
    """
    source = starter_files()
    there = [part for part in STARTER_PARTS if (folder / part).exists()]
    if there:
        raise InputError(f"{folder} has {', '.join(there)} already: nothing was written")
    for part in STARTER_PARTS:
        copy = folder / part
        copy.parent.mkdir(parents=True, exist_ok=True)
        if (source / part).is_dir():
            shutil.copytree(source / part, copy, ignore=_LEFT_OUT)
        else:
            shutil.copy2(source / part, copy)
    return [folder / part for part in STARTER_PARTS]

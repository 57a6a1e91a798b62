"""Files of a study: paths of its results, plans of its rounds, and the starter files."""

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError
from skewbridge.files.digests import PACKAGE
from skewbridge.files.text import read_json

DEFAULT_ROOT: Final = "results"
#: Descriptions of the columns of each table.
COLUMNS_FILE: Final = Path(__file__).with_name("columns.yaml")
#: Starter files, as paths in a clone; pyproject.toml installs them next to the package.
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
#: Reasons for the end of a study in rounds, and their messages.
ALL_DECIDED: Final = "decided"
OUT_OF_REACH: Final = "most"
OUT_OF_TIME: Final = "hours"
_ENDS: Final = {
    ALL_DECIDED: "",
    OUT_OF_REACH: "; the most motions (design.most, or all of the suite) do not decide the others",
    OUT_OF_TIME: "; the time is used up (design.hours {hours:g}): set a larger value to resume",
}


def default_root(configuration: str | Path) -> str:
    """Return the folder of a study: `results/NAME` for `config/NAME.yaml`, else `results`."""
    path = Path(configuration).resolve()
    is_named = path.parent.name == "config" and path.stem != "config"
    return f"{DEFAULT_ROOT}/{path.stem}" if is_named else DEFAULT_ROOT


class StudyFolder:
    """Paths of the files of a study."""

    def __init__(self, root: Path = Path(DEFAULT_ROOT)) -> None:
        self.root: Final = root
        self.configuration: Final = root / "configuration.json"  # see `store_configuration`
        self.suite: Final = root / "motions/suite.parquet"  # motions with their factors
        self.intensities: Final = root / "motions/intensities.parquet"  # at factor 1, by bridge
        self.selected: Final = root / "motions/selected"  # index and files of selected motions
        self.selection: Final = root / "motions/selection.json"  # its summary by level
        self.pilot: Final = root / "motions/pilot.json"  # medians that set the levels
        self.motions_digest: Final = root / "motions/digest.json"  # cache for unchanged files
        self.demands: Final = root / "demands.parquet"  # demands of all variants
        self.limit_states: Final = root / "limit_states.yaml"  # copy by `skewbridge statistics`
        self.rounds: Final = root / "rounds.parquet"  # headline effects after every round
        self.sensitivity: Final = root / "sensitivity.parquet"  # numerical check
        self.modelling_choices: Final = root / "modelling_choices.parquet"
        self.verification: Final = root / "verification"
        self.contact_checks: Final = self.verification / "contact_checks.parquet"
        self.figures: Final = root / "figures"
        self.captions: Final = root / "captions.json"  # written when all figures are drawn
        self.checks: Final = root / "checks.json"  # checks of the tables
        self.report: Final = root / "report.html"
        self.solver_logs: Final = root / "logs/solver"

    def journal(self, name: str) -> Path:
        """Return the path of the journal of one job, which analyses a variant or serves a rule."""
        return self.root / "journal" / f"{name}.jsonl"

    @property
    def journals(self) -> list[Path]:
        """Journals of all jobs so far, including jobs of earlier studies in this folder."""
        return sorted(self.root.glob("journal/*.jsonl"))

    def variant_demands(self, variant: str) -> Path:
        """Return the path of the demands of one variant."""
        return self.root / "demands" / f"{variant}.parquet"

    def round(self, number: int | str) -> Path:
        """Return the path of the plan of a round."""
        return self.root / "rounds" / f"round{number}.json"

    def round_demands(self, number: int | str, variant: str) -> Path:
        """Return the path of the demands of one variant in a round."""
        return self.root / "demands" / f"round{number}" / f"{variant}.parquet"

    def demands_files(self, variant: str) -> list[Path]:
        """Return all demands files of one variant, including files of rounds."""
        return sorted(self.root.glob(f"demands/**/{variant}.parquet"))

    def fragility(self, table: str, ending: str = "parquet") -> Path:
        """Return the path of a table in the folder ``fragility``."""
        return self.root / "fragility" / f"{table}.{ending}"

    @property
    def report_inputs(self) -> dict[str, Path]:
        """Input files of the page as a dictionary, without the figures in their separate folder."""
        files = ("captions", "demands", "suite", "contact_checks", "checks", "sensitivity")
        fits = ("curves", "effects", "needed_motions", "intensity_effects", "input_notes", "suites")
        optional = ("system", "joint", "shear_models", "alternatives", "rates", "rate_effects")
        return {
            **{name: getattr(self, name) for name in files},
            **{name: self.fragility(name) for name in (*fits, *optional)},
            "medians": self.fragility("median_effects"),
        }

    def has_lost_figures(self) -> bool:
        """Return whether the folder of the figures lacks a figure that has a caption."""
        if not (self.captions.is_file() and self.figures.is_dir()):
            return False  # Snakemake draws all figures
        names = (figure["name"] for figure in read_json(self.captions)["figures"])
        files = (self.figures / f"{name}.{ending}" for name in names for ending in ("svg", "png"))
        return not all(file.is_file() for file in files)

    def log(self, rule: str) -> Path:
        """Return the path of the log of a rule."""
        return self.root / "logs" / f"{rule}.log"

    def benchmark(self, job: str) -> Path:
        """Return the file in which Snakemake writes the cost of a job."""
        return self.root / "benchmarks" / f"{job}.tsv"


def round_line(plan: Mapping[str, Any]) -> str:
    """Return a line on the plan of a round: decided effects, then the next analyses or the end."""
    number, cells = plan["round"], len(plan["cells"])
    text = f"{plan['decided']} of {cells} headline effects decided"
    if plan["ended"] is not None:
        return f"rounds ended after round {number - 1}: {text}{_ENDS[plan['ended']].format(**plan)}"
    minutes = max(round(plan["forecast_s"] / 60), 1)
    text = f"round {number}: {text}; " if cells else f"round {number}: "
    return f"{text}next {plan['analyses']} analyses, about {minutes} min"


def last_plan(folder: StudyFolder) -> dict[str, Any] | None:
    """Return the plan of the present or last round of a study; None before the first."""
    plan, number = None, 1
    # files after the plan that ended the study belong to an earlier configuration
    while (path := folder.round(number)).is_file() and not (plan and plan["ended"]):
        plan, number = read_json(path), number + 1
    return plan


def tables_of_round(folder: StudyFolder, plan: Path) -> list[Path]:
    """Return the demands tables that a round produces; none if the study ends with this plan."""
    content = read_json(plan)
    changed = [slug for slug, (before, after) in content["motions"].items() if after > before]
    return [folder.round_demands(content["round"], slug) for slug in changed]


def limit_of_round(plan: Path, hours: float) -> float:
    """Return the time limit (h) in the plan of a round, or ``hours`` if more time is given now.

    More time counts only if the plan ended for lack of time. The limit is a parameter of the
    checkpoint, so Snakemake then plans the round again.
    """
    if not plan.is_file():
        return hours
    planned = read_json(plan)
    return max(planned["hours"], hours) if planned["ended"] == OUT_OF_TIME else planned["hours"]


def starter_files(package: Path = PACKAGE) -> Path:
    """Return the folder of the starter files: next to the package, or the root of a clone."""
    for folder in (package.parent / "skewbridge_starter", package.parents[1]):
        if all((folder / name).exists() for name in STARTER_PARTS):
            return folder
    problem = f"the starter files of a study are not next to {package}"
    raise InputError(f"{problem}: install the package again")


def write_starter(folder: Path) -> list[Path]:
    """Write the starter files of a study, unless one of them exists; return files and folders."""
    source = starter_files()
    if existing := [name for name in STARTER_PARTS if (folder / name).exists()]:
        raise InputError(f"{folder} already has {', '.join(existing)}: nothing was written")
    for name in STARTER_PARTS:
        copy = folder / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        if (source / name).is_dir():
            shutil.copytree(source / name, copy, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        else:
            shutil.copy2(source / name, copy)
    return [folder / name for name in STARTER_PARTS]

"""Archive of a finished study as one RO-Crate: tables, report, workflow and configuration.

References:
    Sefton et al., RO-Crate metadata specification; Workflow RO-Crate profile 1.0.
"""

import re
import warnings
from collections import defaultdict
from collections.abc import Sequence
from hashlib import sha256
from importlib.metadata import metadata, requires, version
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Final

import yaml
from rocrate.model import ContextEntity, Person
from rocrate.rocrate import ROCrate

from skewbridge.bridge.library import structure_files
from skewbridge.errors import InputError, SolutionError
from skewbridge.files.digests import licence_of
from skewbridge.files.tables import read_frame, read_stamp
from skewbridge.files.text import read_bytes, writable_file, written_aside
from skewbridge.report.answer import sentence
from skewbridge.report.methods import methods_of
from skewbridge.study.config import StudyConfig, load_config
from skewbridge.study.folder import StudyFolder, starter_files
from skewbridge.study.jobs import origin_of
from skewbridge.study.results import load_results

#: Patterns of the archived files in the folder of a study, with their descriptions.
TAKEN: Final = {
    "demands.parquet": "demands of every analysis",
    "fragility/*": "fits and effects",
    "sensitivity.parquet": "analyses repeated at the reference accuracy",
    "modelling_choices.parquet": "effects of modelling choices",
    "motions/intensities.parquet": "intensity measures",
    "verification/*.parquet": "contact checks before the analyses",
    "checks.json": "checks of the tables",
    "report.html": "report",
}
#: Files of the workflow, from which `snakemake` repeats the study.
_WORKFLOW: Final = ("Snakefile", "workflow/**/*", "profiles/**/*")
_MAIN: Final = "workflow/Snakefile"
_TYPES: Final = {
    ".parquet": "application/vnd.apache.parquet", ".csv": "text/csv", ".json": "application/json",
    ".html": "text/html", ".md": "text/markdown", ".yaml": "application/yaml",
    ".tex": "application/x-tex",
}  # fmt: skip
#: Licence of the results.
LICENCE: Final = "https://creativecommons.org/licenses/by/4.0/"
_MAX_BYTES: Final = 2_000_000_000


def write_archive(
    config: Path, base: Path, out: Path, authors: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Write a finished study as a Workflow RO-Crate in a ZIP file.

    Accelerations are left out, because records may not be redistributed; ``motions.csv`` has their
    sources and digests. ``ro-crate-metadata.json`` has the SHA-256 of every file. ``config`` is
    merged over ``base``. Returns the names of the files, and reservations about the results, one
    sentence each.
    """
    study = load_config(config, base=base)
    folder = study.folder
    missing = [path for path in (folder.demands, folder.fragility("curves")) if not path.is_file()]
    if missing:
        raise InputError(f"{missing[0]} is missing: finish the study first")
    stamp, doubts = read_stamp(folder.demands), _doubts(folder, study)
    edited = " with local changes" if stamp.get("git_dirty") == "yes" else ""
    versions = defaultdict(lambda: "unknown", stamp)
    crate = ROCrate()
    crate.name = f"Fragility study of {', '.join(study.grid.bridge)} with skewbridge"
    crate.description = sentence("archive", versions=versions, changed=edited, doubts=doubts)
    terms = {"@type": "CreativeWork", "name": LICENCE, "description": "terms of the results"}
    crate.license = crate.add(ContextEntity(crate, LICENCE, terms))
    for number, name in enumerate(authors, start=1):
        author = crate.add(Person(crate, f"#author{number}", {"name": name}))
        crate.root_dataset.append_to("author", author, compact=True)
    for name, (content, text) in sorted(_files(study, folder, config, base).items()):
        properties = {
            "name": name,
            "description": text,
            "encodingFormat": _TYPES.get(Path(name).suffix, "text/plain"),
            "contentSize": str(len(content)),
            "sha256": sha256(content).hexdigest(),
        }
        if name == _MAIN:
            crate.add_workflow(
                BytesIO(content), name, properties=properties, main=True, lang="snakemake",
                lang_version=version("snakemake"),
            )  # fmt: skip
        else:
            crate.add_file(BytesIO(content), name, properties=properties)
    with written_aside(writable_file(out)) as temporary:
        crate.write_zip(temporary)
    return sorted(entity.id for entity in crate.data_entities if entity.type != "Dataset"), doubts


def _files(
    study: StudyConfig, folder: StudyFolder, config: Path, base: Path
) -> dict[str, tuple[bytes, str]]:
    """Return a dict from the name of each file in the archive to its content and description."""
    suite = read_frame(folder.suite)
    all_keys = yaml.safe_dump(study.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
    motions = suite.loc[:, ~suite.columns.str.startswith("accel_")].to_csv(index=False)
    requirements = [line for line in requires("skewbridge") or () if "extra ==" not in line]
    names = sorted(re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in requirements)
    packages = [(name, metadata(name)) for name in ("skewbridge", *names)]
    lines = (f"{name}=={data['Version']}  # {licence_of(data)}\n" for name, data in packages)
    software = "".join(lines)
    files = {
        "whole_config.yaml": (all_keys.encode(), "configuration with every key"),
        "motions.csv": (motions.encode(), "motions with sources, factors and digests"),
        "METHODS.md": (methods_of(study, suite).markdown().encode(), "methods for a paper"),
        "requirements.txt": (software.encode(), "packages with versions and licences"),
    }
    starter, content = starter_files(), dict[str, tuple[Path, str]]()
    for path in chain.from_iterable(starter.glob(pattern) for pattern in _WORKFLOW):
        if path.is_file() and "__pycache__" not in path.parts:
            content[path.relative_to(starter).as_posix()] = path, "workflow"
    bridges = chain.from_iterable(map(structure_files, study.grid.bridge))
    for path in (base, config, Path(study.fragility.limit_states), *bridges):
        absolute, cwd = path.resolve(), Path.cwd()
        local = absolute.relative_to(cwd) if absolute.is_relative_to(cwd) else None
        content[(local or Path("config/elsewhere", path.name)).as_posix()] = path, "configuration"
    for pattern, text in TAKEN.items():
        for path in folder.root.glob(pattern):
            content[f"results/{path.relative_to(folder.root).as_posix()}"] = path, text
    return files | {
        name: (read_bytes(path, _MAX_BYTES), text) for name, (path, text) in content.items()
    }


def _doubts(folder: StudyFolder, study: StudyConfig) -> list[str]:
    """Return one sentence for each reason to doubt that the tables match the present study."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_results(folder.root)
    doubts = [str(warning.message) for warning in caught if warning.category is UserWarning]
    try:
        origin = origin_of(folder.demands, lambda: study)
    except (InputError, SolutionError) as error:
        return [*doubts, f"not compared with the present sources and configuration: {error}"]
    if not origin["current"]:
        differing = ", ".join(origin["differences"])
        doubts.append(f"demands were made with different sources or configuration ({differing})")
    return doubts

"""Archive of a study for the supplement of a paper, with instructions to repeat it."""

import hashlib
import json
import re
import warnings
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import distribution, metadata, requires
from pathlib import Path
from typing import Final

import pandas as pd
import yaml

from skewbridge.bridge.catalogue.loading import own_bridge_files
from skewbridge.errors import InputError, SolutionError
from skewbridge.files.digests import PACKAGE, licence_of
from skewbridge.files.tables import read_frame, read_stamp
from skewbridge.files.text import read_bytes, writable_file, written_aside
from skewbridge.fragility.study_tables import load_results
from skewbridge.report.methods import methods_of
from skewbridge.study.config import StudyConfig, load_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.products import origin_of

#: Patterns of the archived files in the folder of a study; parquet, CSV, JSON, LaTeX and the page.
TAKEN: Final = (
    "demands.parquet",
    "fragility/*",
    "sensitivity.parquet",
    "modelling_choices.parquet",
    "motions/intensities.parquet",
    "verification/*.parquet",
    "checks.json",
    "report.html",
)
#: The folder that the archive unpacks to.
TOP: Final = "study"
#: Date of every file, so that equal contents give equal bytes: the earliest date of ZIP.
_DATE: Final = (1980, 1, 1, 0, 0, 0)
_ACCELERATIONS: Final = ["accel_1_mps2", "accel_2_mps2"]
_MAX_BYTES: Final = 2_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Archive:
    """An archive that was written.

    Attributes:
        path: The file.
        names: Names of the files in it.
        sha256: SHA-256 of the file.
        doubts: Reservations for readers of the paper, one sentence each.
    """

    path: Path
    names: tuple[str, ...]
    sha256: str
    doubts: tuple[str, ...]


def write_archive(config: Path, base: Path, out: Path) -> Archive:
    """Write configuration, tables, digests, licences and the command to repeat into a ZIP file.

    Equal studies give equal bytes. Accelerations are left out: recorded motions may not be passed
    on, and the sources and digests of all motions are in ``motions.csv``.

    Args:
        config: Configuration of the finished study.
        base: Configuration that it is merged over.
        out: The file to write.

    Raises:
        InputError: The study is not finished.
    """
    study = load_config(config, base=base)
    folder = StudyFolder(Path(study.results))
    missing = [path for path in (folder.demands, folder.fragility("curves")) if not path.is_file()]
    if missing:
        raise InputError(f"{missing[0]} is missing: finish the study first")
    suite = read_frame(folder.suite)
    doubts = _doubts(folder, config, base)
    files = {
        **_inputs(study, config, base),
        **{name: path.read_bytes() for name, path in _products(folder).items()},
        "motions.csv": _motions(suite).encode(),
        "METHODS.md": methods_of(study, suite).markdown().encode(),
        "provenance.json": _json(dict(sorted(read_stamp(folder.demands).items()))),
        **_licences(),
    }
    files["README.md"] = _readme(folder, sorted(files), doubts).encode()
    files["SHA256SUMS"] = "".join(
        f"{hashlib.sha256(files[name]).hexdigest()}  {name}\n" for name in sorted(files)
    ).encode()
    _write_zip(files, writable_file(out))
    return Archive(
        path=out,
        names=tuple(sorted(files)),
        sha256=hashlib.sha256(out.read_bytes()).hexdigest(),
        doubts=doubts,
    )


def _products(folder: StudyFolder) -> dict[str, Path]:
    found = {path for pattern in TAKEN for path in folder.root.glob(pattern) if path.is_file()}
    return {f"results/{path.relative_to(folder.root).as_posix()}": path for path in found}


def _inputs(study: StudyConfig, config: Path, base: Path) -> dict[str, bytes]:
    """Return the whole configuration, and the files that it was read from."""
    whole = yaml.safe_dump(study.model_dump(mode="json"), sort_keys=False, allow_unicode=True)
    paths = [base, config, Path(study.fragility.limit_states)]
    for name in study.grid.bridge:
        paths += own_bridge_files(name)
    read = {_inside(path): read_bytes(path, _MAX_BYTES) for path in dict.fromkeys(paths)}
    return {"whole_config.yaml": whole.encode(), **read}


def _inside(path: Path) -> str:
    """Return the name of an input in the archive: as in the folder of the study, if it is there."""
    try:
        return path.resolve().relative_to(Path.cwd()).as_posix()
    except ValueError:
        return f"config/elsewhere/{path.name}"


def _motions(suite: pd.DataFrame) -> str:
    return suite.drop(columns=_ACCELERATIONS, errors="ignore").to_csv(index=False)


def _licences() -> dict[str, bytes]:
    """Return the licence of this program, those that the packages state, and their versions."""
    own = distribution("skewbridge").read_text("licenses/LICENSE")
    licence = PACKAGE.parents[1] / "LICENSE"
    if own is None and licence.is_file():
        own = licence.read_text(encoding="utf-8")
    lines = ["# Licences of the packages that the study was made with", ""]
    needed = [each for each in requires("skewbridge") or () if "extra ==" not in each]
    for name in sorted(re.split(r"[^\w.-]", each, maxsplit=1)[0] for each in needed):
        package = metadata(name)
        lines.append(f"- {name} {package['Version']}: {licence_of(package)}")
    lines += [
        "",
        "OpenSees and OpenSeesPy are free for research, education and internal use; commercial "
        "redistribution needs a licence from their authors. Sources and terms of the ground "
        "motions: column `source` of `motions.csv`.",
        "",
    ]
    return {
        "licences/packages.md": "\n".join(lines).encode(),
        **({} if own is None else {"licences/skewbridge.txt": own.encode()}),
    }


def _doubts(folder: StudyFolder, config: Path, base: Path) -> tuple[str, ...]:
    """Return the ways in which the tables differ from the study as configured now."""
    doubts: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load_results(folder.root)
    doubts += [str(warning.message) for warning in caught if warning.category is UserWarning]
    try:
        origin = origin_of(folder.demands, config, base)
    except (InputError, SolutionError) as error:
        return (*doubts, f"not compared with the present sources and configuration: {error}")
    if not origin.is_current:
        differing = ", ".join(origin.differences)
        doubts.append(f"the present sources or configuration give other demands ({differing})")
    return tuple(doubts)


def _readme(folder: StudyFolder, names: list[str], doubts: tuple[str, ...]) -> str:
    stamp = read_stamp(folder.demands)
    commit = stamp.get("git_commit", "unknown")
    changed = " with local changes" if stamp.get("git_dirty") == "yes" else ""
    listed = "\n".join(f"- `{name}`" for name in names)
    doubted = "".join(f"- {doubt}\n" for doubt in doubts) or "- none found\n"
    return f"""# A study of skewbridge {stamp.get("skewbridge_version", "")}

Made with commit {commit}{changed} on Python {stamp.get("python_version", "?")} and OpenSeesPy
{stamp.get("openseespy_version", "?")}. The metadata of every table state its origin;
`SHA256SUMS` has the digest of every file here (`sha256sum -c SHA256SUMS`).

## Repeat it

In a clone at this commit, with `config/` of this archive over that of the clone and the motions of
`motions.csv` in the folder that `whole_config.yaml` names:

    make setup
    make study CONFIG=path/to/whole_config.yaml

The analyses do not depend on the number of processes or on what was interrupted.

## Doubts

{doubted}
## Files

{listed}
"""


def _json(content: Mapping[str, str]) -> bytes:
    return json.dumps(content, indent=1).encode()


def _write_zip(files: Mapping[str, bytes], out: Path) -> None:
    """Write files in the order of their names, with one date and one mode for all."""
    with written_aside(out) as part, zipfile.ZipFile(part, "w") as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(f"{TOP}/{name}", date_time=_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, on every system
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name], compresslevel=9)

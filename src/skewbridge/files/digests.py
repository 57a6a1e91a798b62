"""Digests of sources and values, and provenance: versions, commit, machine, licences."""

import hashlib
import os
import platform
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, partial
from importlib.metadata import PackageMetadata, version
from pathlib import Path
from typing import Any, Final

from skewbridge.files.text import file_fault

#: Folder of the package.
PACKAGE: Final = Path(__file__).parents[1]
#: Sources that an analysis executes. The key of an analysis contains their digest, so an edit
#: repeats all analyses. Readers of motions, scheduling and journals are not included: the
#: accelerations themselves are part of the key.
ENGINE: Final = (
    "errors.py",
    "statuses.py",
    "units.py",
    "files/text.py",
    "variant",
    "motions/record.py",
    "contact",
    "bridge",
    "analysis",
    "study/task.py",
)
#: YAML files here are left out of digests, because each bridge has a digest of its own numbers.
_CATALOGUE: Final = Path("bridge", "catalogue")
_PACKAGES: Final = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "skewbridge")


def layer_digest(parts: Sequence[str], package: Path = PACKAGE) -> str:
    """Return the digest (16 hex digits) of modules and folders (``parts``) of the package."""
    return layer_digests({"": parts}, package)[""]


def layer_digests(layers: Mapping[str, Sequence[str]], package: Path = PACKAGE) -> dict[str, str]:
    """Return the `layer_digest` of each named list of modules; shared modules are read once."""
    content = cache(partial(_contents, package=package))
    return {
        name: hashlib.sha256(b"".join(map(content, parts))).hexdigest()[:16]
        for name, parts in layers.items()
    }


def _contents(module: str, package: Path) -> bytes:
    """Return names and contents of source and data files of one module or folder."""
    source = package / module
    if not source.exists():
        raise FileNotFoundError(f"{source} is not a part of the package")
    paths = sorted(source.rglob("*")) if source.is_dir() else [source]
    relative_paths = [path.relative_to(package) for path in paths if path.is_file()]
    return b"".join(
        f"\n{relative_path.as_posix()}\n".encode() + (package / relative_path).read_bytes()
        for relative_path in relative_paths
        if not relative_path.name.endswith((".pyc", "~"))
        and not any(part.startswith(".") for part in relative_path.parts)
        and not (relative_path.parent == _CATALOGUE and relative_path.suffix == ".yaml")
    )


@cache
def engine_digest() -> str:
    """Return the digest of the sources that an analysis executes."""
    return layer_digest(ENGINE)


def digest_of(*parts: object) -> str:
    """Return the digest (16 hex digits) of the `repr` of plain values: numbers, texts, tuples."""
    return hashlib.sha256("\n".join(repr(item) for item in parts).encode()).hexdigest()[:16]


def file_states(files: Iterable[Path]) -> list[tuple[str, int, int]]:
    """Return path, size and time of files; `InputError` for one removed since it was listed."""
    states: list[tuple[str, int, int]] = []
    for path in files:
        try:
            state = path.stat()
        except OSError as error:
            raise file_fault(path, f" cannot be read: {error.strerror}") from None
        states.append((str(path), state.st_size, state.st_mtime_ns))
    return states


def canonical(value: Any) -> Any:
    """Convert nested mappings (sorted by key) and sequences to tuples for `digest_of`."""
    if isinstance(value, Mapping):
        return tuple((str(key), canonical(value[key])) for key in sorted(value))
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(canonical(element) for element in value)
    return value


@cache
def opensees_version() -> str:
    """Return the version of OpenSeesPy."""
    return version("openseespy")


def provenance(**digests: str) -> dict[str, str]:
    """Return the provenance of a result: versions, commit, processor and digests, no host name."""
    commit = _git("rev-parse", "--short=12", "HEAD")
    changed_files = _git("status", "--porcelain", "--untracked-files=no")
    return {
        # with a suffix, because pandas itself writes a key "pandas"
        "python_version": platform.python_version(),
        **{f"{name}_version": version(name) for name in _PACKAGES},
        "git_commit": commit or "unknown",
        "git_dirty": "unknown" if commit is None else ("yes" if changed_files else "no"),
        "processor": _processor(),
        "processors": str(os.cpu_count()),
        **digests,
    }


@cache
def _git(*arguments: str) -> str | None:
    """Return the output of a git command in the clone of the package, None without a clone."""
    command = ["git", "-C", str(PACKAGE), *arguments]
    # no repository above the root of a clone, such as one in which the package is installed
    env = os.environ | {"GIT_CEILING_DIRECTORIES": str(PACKAGE.parents[2])}
    try:
        result = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
    except OSError:
        return None
    return result.stdout.strip() if result.returncode == 0 else None


def _processor() -> str:
    cpu_info = Path("/proc/cpuinfo")
    lines = cpu_info.read_text(encoding="utf-8").splitlines() if cpu_info.is_file() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def licence_of(package: PackageMetadata) -> str:
    """Return the licence of a package from its expression, classifiers or text, in this order."""
    classifiers = [
        text.rpartition(" :: ")[2]
        for text in package.get_all("Classifier") or []
        if text.startswith("License :: ")
    ]
    text = (package.get("License") or "").strip().split("\n")[0][:80]
    return package.get("License-Expression") or ", ".join(classifiers) or text or "not stated"

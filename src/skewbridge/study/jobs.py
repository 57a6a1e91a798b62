"""Workflow jobs: dependencies, sessions of scripts, and provenance of outputs."""

import errno
import logging
import os
import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from skewbridge.bridge.library import load_structure
from skewbridge.errors import EXIT_BAD_INPUT, EXIT_FAILED, InputError, SolutionError
from skewbridge.files.digests import (
    ENGINE,
    canonical,
    digest_of,
    engine_digest,
    layer_digest,
    layer_digests,
    opensees_version,
    provenance,
)
from skewbridge.files.tables import read_stamp, stamp
from skewbridge.files.text import read_yaml
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.study.config import CONDITIONING_BRIDGE, StudyConfig, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import motions_digest
from skewbridge.study.processes import PROCESSORS, PROGRESS_LOG, end_with_parent, hush_exit_message
from skewbridge.variant.grid import expand_grid

if TYPE_CHECKING:  # a job without analyses does not import OpenSees
    from skewbridge.study.analyses import StudySetup

logger = logging.getLogger("skewbridge")

EXIT_INTERRUPTED: Final = 130

#: Errors caused by the disk or access rights, not by the program.
_OF_THE_DISK: Final = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EFBIG, errno.EIO}
)
# ASSUME with this many variants per processor, a further worker costs more than idle processors
# (durations of the default study: sharing a processor takes 2 % more of its time)
_MANY_VARIANTS: Final = 8
#: Keys of the configuration that do not affect results.
_NO_RESULT: Final = {"results", "batches"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """Dependencies of the outputs of a rule, see recipes.yaml."""

    sources: tuple[str, ...]
    sections: tuple[str, ...] = ()
    after: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()


def _recipes() -> dict[str, Recipe]:
    content = read_yaml(Path(__file__).with_name("recipes.yaml"))
    result_sections = tuple(name for name in StudyConfig.model_fields if name not in _NO_RESULT)
    groups: dict[str, tuple[str, ...]] = {"engine": ENGINE, "all": result_sections}

    def spelled(names: Sequence[str]) -> tuple[str, ...]:
        """Return names with each group replaced by its members."""
        return tuple(member for name in names for member in groups.get(name, (name,)))

    for name, members in content["groups"].items():  # a group may contain earlier groups
        groups[name] = spelled(members)
    return {
        rule: Recipe(**{field: spelled(names) for field, names in recipe.items()})
        for rule, recipe in content["rules"].items()
    }


RECIPES: Final[Mapping[str, Recipe]] = _recipes()


def made_from(study: StudyConfig) -> dict[str, dict[str, str]]:
    """Return, for each rule, the digests (by name) of everything that its outputs depend on.

    They are parameters of the rules, so that Snakemake reruns rules whose digests have changed.
    """
    periods = {name: load_structure(name).t1_s for name in study.bridges_with_periods()}
    structures = {Path(name).stem: load_structure(name) for name in study.grid.bridge}
    inputs = {
        "motions": motions_digest(study, study.folder.motions_digest),
        "periods": digest_of(canonical(periods), periods[CONDITIONING_BRIDGE]),
        "bridges": digest_of(canonical({n: bridge.digest for n, bridge in structures.items()})),
        "titles": digest_of(*(bridge.description.title for bridge in structures.values())),
        "opensees": opensees_version(),
        "variants": digest_of(*sorted(variant.slug for variant in expand_grid(study.grid))),
        "hazard": digest_of(study.hazard_curve),
        "limit_states": digest_of(load_limit_states(Path(study.fragility.limit_states))),
    }
    sources = layer_digests({rule: recipe.sources for rule, recipe in RECIPES.items()})
    values = study.model_dump(mode="json")
    digests: dict[str, dict[str, str]] = {}
    for rule, recipe in RECIPES.items():
        digests[rule] = {
            "sources": sources[rule],
            # `motions` is both a section and an input
            **{f"{name}:": digest_of(canonical(values[name])) for name in recipe.sections},
            **{name: inputs[name] for name in recipe.inputs},
            **({"motions": inputs["motions"]} if recipe.after else {}),
            **{name: rule_digest(digests[name]) for name in recipe.after},
        }
    return digests


def rule_digest(digests: Mapping[str, str]) -> str:
    """Return one digest of everything that the outputs of a rule depend on."""
    return digest_of(canonical(digests))


def stamp_of(rule: str, digests: Mapping[str, str], study: StudyConfig) -> dict[str, str]:
    """Return the provenance of a rule's outputs; `digests` holds the digests of the inputs."""
    values = study.model_dump(mode="json", exclude=_NO_RESULT)
    return provenance(
        rule=rule,
        rule_digest=rule_digest(digests),
        config_digest=digest_of(canonical(values)),
        suite_digest=digests.get("motions", "none"),
    )


def origin_of(path: Path, find_study: Callable[[], StudyConfig]) -> dict[str, Any]:
    """Return the provenance of a file of a study or ``skewbridge run``, and whether it is current.

    Keys: ``current``, ``provenance`` (as recorded), ``now`` (as it would be recorded) and
    ``differences``. An output is current if its rule (of `find_study`), or the engine and OpenSees,
    are unchanged. `InputError` for a file without provenance.
    """
    recorded = read_stamp(path)
    now = {name: value for name, value in provenance().items() if name in recorded}
    decisive = ["openseespy_version"]
    if "rule" in recorded:
        study = find_study()
        digests = made_from(study).get(recorded["rule"], {"motions": "unknown"})
        expected = stamp_of(recorded["rule"], digests, study)
        now |= {name: expected[name] for name in ("rule_digest", "config_digest", "suite_digest")}
        decisive = ["rule_digest"]
    elif "engine_digest" in recorded:
        now["engine_digest"] = engine_digest()
        decisive += ["engine_digest"]
    else:
        problem = "records package versions but no digest of the sources, so it cannot be checked"
        text = f"{path} {problem}: `skewbridge statistics` or an earlier version wrote it"
        raise InputError(text, file=str(path))
    differences = [name for name, value in now.items() if recorded.get(name) != value]
    current = not set(decisive) & set(differences)
    return {"current": current, "provenance": recorded, "now": now, "differences": differences}


# ---- Scripts


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A workflow job as seen by its script; ``stamp`` is the provenance of its outputs."""

    study: StudyConfig
    inputs: Mapping[str, Path]
    outputs: Mapping[str, Path]
    threads: int
    stamp: Mapping[str, str]

    @property
    def folder(self) -> StudyFolder:
        """Files of the study; folders of `skewbridge init` have scripts that use it."""
        return self.study.folder

    @property
    def processors(self) -> int:
        """Processors of the workflow on this machine; 1 on a cluster."""
        return int(os.environ.get(PROCESSORS, 1))

    @property
    def setup(self) -> "StudySetup":
        """Setup of the analyses of the job."""
        from skewbridge.study.analyses import StudySetup

        # one worker more than threads: no processor is idle while jobs start and the last ones end
        n_variants = len(expand_grid(self.study.grid))
        is_shared = self.processors > 1 and n_variants < _MANY_VARIANTS * self.processors
        return StudySetup.of(self.study, self.threads + is_shared)

    def current(self, path: Path, digests: Mapping[str, str]) -> Path | None:
        """Return the path of an optional table if it exists and is current, else None."""
        if not path.is_file() or read_stamp(path).get("rule_digest") != rule_digest(digests):
            return None
        return path


@contextmanager
def script_session(snakemake: Any) -> Generator[Job]:
    """Yield the job of a script; log to a file, and show warnings and progress in the terminal.

    On success, write the provenance into the outputs. On failure, log one sentence and raise
    `SystemExit`: 2 (input, disk, access rights), 1 (`SolutionError`), 130 (Ctrl-C).
    """
    hush_exit_message()
    end_with_parent()
    logging.raiseExceptions = False  # a full disk that stops the log does not stop the study
    logger.setLevel(logging.INFO)
    to_terminal = logging.StreamHandler(sys.stderr)
    # warnings, errors and the progress of jobs
    to_terminal.addFilter(lambda r: r.levelno >= logging.WARNING or r.name == PROGRESS_LOG)
    logger.addHandler(to_terminal)
    try:
        with _logging_to(Path(snakemake.log[0])):
            digests = snakemake.params.made_from
            study = parse_config({**snakemake.config, "results": snakemake.params.results})
            if digests["sources"] != layer_digest(RECIPES[snakemake.rule].sources):
                problem = "the sources were edited while the study ran"
                raise InputError(f"{problem}: run the same command again")
            job = Job(
                study=study,
                # except inputs that are lists of files
                inputs={n: Path(p) for n, p in snakemake.input.items() if isinstance(p, str)},
                outputs={name: Path(path) for name, path in snakemake.output.items()},
                threads=snakemake.threads,
                stamp=stamp_of(snakemake.rule, digests, study),
            )
            yield job
            for output in filter(Path.is_file, map(Path, snakemake.output)):
                stamp(output, job.stamp)
    except (InputError, SolutionError) as error:
        logger.error("%s", error)
        is_input = isinstance(error, InputError)
        raise SystemExit(EXIT_BAD_INPUT if is_input else EXIT_FAILED) from None
    except KeyboardInterrupt:
        logger.error("interrupted; finished analyses are kept: repeat the command to resume")
        raise SystemExit(EXIT_INTERRUPTED) from None
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            raise
        file = error.filename or f"the results in {snakemake.params.results}"
        advice = "finished analyses are kept: remove the cause and repeat the command"
        logger.error("cannot read or write %s: %s; %s", file, error.strerror or error, advice)
        raise SystemExit(EXIT_BAD_INPUT) from None
    finally:
        logger.removeHandler(to_terminal)


@contextmanager
def _logging_to(log: Path) -> Generator[None]:
    log.unlink(missing_ok=True)  # log of the last run
    to_file = logging.FileHandler(log, mode="w", delay=True)  # created by the first message
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    logger.addHandler(to_file)
    try:
        yield
    finally:
        logger.removeHandler(to_file)
        to_file.close()

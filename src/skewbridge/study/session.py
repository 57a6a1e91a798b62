"""Scripts of the workflow: their configuration, log, error messages and stamped outputs."""

import errno
import logging
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from skewbridge.errors import EXIT_BAD_INPUT, EXIT_FAILED, InputError, SolutionError
from skewbridge.files.digests import layer_digest
from skewbridge.files.tables import read_stamp, stamp
from skewbridge.study.config import StudyConfig, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.processes import PROGRESS_LOG, end_with_parent, hush_exit_message
from skewbridge.study.products import RECIPES, rule_digest, stamp_of

if TYPE_CHECKING:  # a job that runs no analysis does without OpenSees
    from skewbridge.study.batch import Workers

logger = logging.getLogger("skewbridge")

EXIT_INTERRUPTED: Final = 130
#: Errors of the disk or its access rights, not of the program.
_OF_THE_DISK: Final = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EFBIG, errno.EIO}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A job of the workflow, as its script sees it; the stamp is the provenance of its outputs."""

    study: StudyConfig
    folder: StudyFolder
    inputs: Mapping[str, Path]
    outputs: Mapping[str, Path]
    threads: int
    stamp: Mapping[str, str]

    @property
    def workers(self) -> "Workers":
        """Worker processes for the analyses of the job."""
        from skewbridge.study.batch import Workers

        return Workers(count=self.threads, no_progress_s=self.study.batches.no_progress_s)

    def current(self, path: Path, made: Mapping[str, str]) -> Path | None:
        """Return the path of an optional table, made on request, if its digests are current."""
        if not path.is_file() or read_stamp(path).get("rule_digest") != rule_digest(made):
            return None
        return path


@contextmanager
def script_session(snakemake: Any) -> Generator[Job]:
    """Yield the job of a script; log to a file, and show warnings and progress in the terminal.

    When the script is through, its provenance is written into its outputs.

    Raises:
        SystemExit: In one sentence: 2 after an `InputError` or a full disk, 1 after a
            `SolutionError`, 130 after Ctrl-C.
    """
    hush_exit_message()
    end_with_parent()
    logging.raiseExceptions = False  # a full disk that stops the log does not stop the study
    logger.setLevel(logging.INFO)
    to_terminal = logging.StreamHandler(sys.stderr)
    to_terminal.addFilter(for_terminal)
    logger.addHandler(to_terminal)
    try:
        with _logging_to(snakemake.log[0]):
            job = _job(snakemake)
            yield job
            for output in map(Path, snakemake.output):
                if output.is_file():
                    stamp(output, job.stamp)
    except InputError as error:
        logger.error("%s", error)
        raise SystemExit(EXIT_BAD_INPUT) from None
    except SolutionError as error:
        logger.error("%s", error)
        raise SystemExit(EXIT_FAILED) from None
    except KeyboardInterrupt:
        logger.error("interrupted; finished analyses are kept")
        raise SystemExit(EXIT_INTERRUPTED) from None
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            raise
        logger.error("cannot write the results: %s; finished analyses are kept", error)
        raise SystemExit(EXIT_BAD_INPUT) from None
    finally:
        logger.removeHandler(to_terminal)


def _job(snakemake: Any) -> Job:
    study = parse_config({**snakemake.config, "results": snakemake.params.results})
    made = snakemake.params.made_from
    if made["sources"] != layer_digest(RECIPES[snakemake.rule].sources):
        raise InputError("the sources were edited while the study ran: run the same command again")
    return Job(
        study=study,
        folder=StudyFolder(Path(study.results)),
        # not those that are lists of files
        inputs={n: Path(path) for n, path in snakemake.input.items() if isinstance(path, str)},
        outputs={name: Path(path) for name, path in snakemake.output.items()},
        threads=snakemake.threads,
        stamp=stamp_of(snakemake.rule, made, study),
    )


def for_terminal(record: logging.LogRecord) -> bool:
    """Return whether a line is shown in the terminal: warnings, errors, the progress of a job."""
    return record.levelno >= logging.WARNING or record.name == PROGRESS_LOG


@contextmanager
def _logging_to(log: str | Path) -> Generator[None]:
    Path(log).unlink(missing_ok=True)  # of the last run
    to_file = logging.FileHandler(
        log, mode="w", delay=True
    )  # the file is created with the first message
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    logger.addHandler(to_file)
    try:
        yield
    finally:
        logger.removeHandler(to_file)
        to_file.close()

"""What every script of the workflow shares: a log, clear errors, marked outputs, a bounded life."""

import errno
import logging
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.errors import InputError, SolutionError
from skewbridge.study.made_for import mark_outputs
from skewbridge.study.orphans import end_with, workflow_pid

logger = logging.getLogger("skewbridge")

#: Lines of this log are shown where errors are, so that a piped run shows that it goes on.
PROGRESS_LOG: Final = "skewbridge.progress"
EXIT_FAILED: Final = 1
EXIT_BAD_INPUT: Final = 2
#: The disk or its rights, not the program.
_OF_THE_DISK: Final = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EFBIG, errno.EIO}
)


@contextmanager
def script_session(job: Any) -> Generator[None]:
    """Log to a file (everything) and to the terminal (warnings, the progress of a long job).

    Bad input ends in one sentence.

    So does a disk that is full or cannot be written. When the script is through, its outputs are
    told where they come from (`mark_outputs`).

    Args:
        job: The ``snakemake`` of the script.

    Raises:
        SystemExit: With 2 after an `InputError` and 1 after a `SolutionError`, whose message is
            shown alone.
    """
    hush_exit_message()
    end_with(workflow_pid())
    logging.raiseExceptions = False  # a log that the disk has no room for ends nothing
    logger.setLevel(logging.INFO)
    to_terminal = logging.StreamHandler(sys.stderr)
    to_terminal.addFilter(for_terminal)
    logger.addHandler(to_terminal)
    try:
        with _logging_to(job.log[0]):
            yield
            mark_outputs(job.rule, map(Path, job.output), job.config)
    except InputError as error:
        logger.error("%s", error)
        raise SystemExit(EXIT_BAD_INPUT) from None
    except SolutionError as error:
        logger.error("%s", error)
        raise SystemExit(EXIT_FAILED) from None
    except OSError as error:
        if error.errno not in _OF_THE_DISK:
            raise
        logger.error("cannot write the results: %s; what is finished is kept", error)
        raise SystemExit(EXIT_BAD_INPUT) from None
    finally:
        logger.removeHandler(to_terminal)


def for_terminal(record: logging.LogRecord) -> bool:
    """Return whether a line is shown in the terminal: warnings, errors, the progress of a job."""
    return record.levelno >= logging.WARNING or record.name == PROGRESS_LOG


@contextmanager
def _logging_to(log: str | Path) -> Generator[None]:
    Path(log).unlink(missing_ok=True)  # of the last run
    to_file = logging.FileHandler(log, mode="w", delay=True)  # no file without a message
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    logger.addHandler(to_file)
    try:
        yield
    finally:
        logger.removeHandler(to_file)
        to_file.close()

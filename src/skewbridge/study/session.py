"""What every script of the workflow shares: a log, clear errors, marked outputs, a bounded life."""

import logging
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.errors import InputError, SolutionError
from skewbridge.study.made_for import mark_outputs
from skewbridge.study.orphans import end_with, workflow_pid

logger = logging.getLogger("skewbridge")


@contextmanager
def script_session(job: Any) -> Generator[None]:
    """Log to a file (everything) and to the terminal (warnings); bad input ends in one sentence.

    When the script is through, its outputs are told where they come from (`mark_outputs`).

    Args:
        job: The ``snakemake`` of the script.

    Raises:
        SystemExit: With 2 after an `InputError` and 1 after a `SolutionError`, whose message is
            shown alone.
    """
    hush_exit_message()
    end_with(workflow_pid())
    logger.setLevel(logging.INFO)
    to_file = logging.FileHandler(job.log[0], mode="w")
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    to_terminal = logging.StreamHandler(sys.stderr)
    to_terminal.setLevel(logging.WARNING)
    logger.addHandler(to_file)
    logger.addHandler(to_terminal)
    try:
        yield
        mark_outputs(job.rule, map(Path, job.output), job.config)
    except (InputError, SolutionError) as error:
        logger.error("%s", error)
        raise SystemExit(2 if isinstance(error, InputError) else 1) from None
    finally:
        logger.removeHandler(to_terminal)
        logger.removeHandler(to_file)
        to_file.close()

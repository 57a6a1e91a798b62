"""What every script of the workflow shares: a log, clear errors, and no life after the workflow."""

import logging
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.errors import InputError
from skewbridge.study.orphans import end_with, workflow_pid

logger = logging.getLogger("skewbridge")


@contextmanager
def script_session(log: str | Path) -> Generator[None]:
    """Log to a file (everything) and to the terminal (warnings); bad input ends in one sentence.

    Args:
        log: The log file of the rule.

    Raises:
        SystemExit: With 2 after an `InputError`, whose message is shown alone.
    """
    hush_exit_message()
    end_with(workflow_pid())
    logger.setLevel(logging.INFO)
    to_file = logging.FileHandler(log, mode="w")
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    to_terminal = logging.StreamHandler(sys.stderr)
    to_terminal.setLevel(logging.WARNING)
    logger.addHandler(to_file)
    logger.addHandler(to_terminal)
    try:
        yield
    except InputError as error:
        logger.error("%s", error)
        raise SystemExit(2) from None
    finally:
        logger.removeHandler(to_terminal)
        logger.removeHandler(to_file)
        to_file.close()

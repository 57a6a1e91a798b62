"""A study on a Slurm cluster: the size of its jobs, and those that a killed run left behind."""

import logging
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self

import yte
from yte.exceptions import YteError

from skewbridge.errors import InputError

logger = logging.getLogger(__name__)

PROFILES: Final = Path("workflow/profiles")


@dataclass(frozen=True, slots=True, kw_only=True)
class JobSize:
    """What one job of analyses is to be.

    Attributes:
        cores: Its processors.
        cpu_minutes: Processor minutes of its analyses by forecast.
        jobs: How many may be in the queue at once.
    """

    cores: int
    cpu_minutes: int
    jobs: int

    @classmethod
    def of_profile(cls, name: str) -> Self | None:
        """Return the size of the jobs of a profile of Snakemake; None for one of one machine.

        Args:
            name: A folder of `PROFILES`, or a path.

        Raises:
            InputError: There is no such profile, or it is none.
        """
        places = [Path(name), PROFILES / name]
        found = [place / "config.yaml" for place in places if (place / "config.yaml").is_file()]
        if not found:
            raise InputError(f"no profile {name!r}: neither {places[0]} nor {places[1]} has one")
        try:
            with found[0].open(encoding="utf-8") as text:
                profile: Any = yte.process_yaml(text, require_use_yte=True)
            if "executor" not in profile:
                return None
            return cls(
                cores=profile["set-threads"]["analyse"],
                cpu_minutes=profile["set-resources"]["analyse"]["cpu_minutes"],
                jobs=profile["jobs"],
            )
        except (YteError, KeyError, TypeError) as error:
            raise InputError(f"{found[0]} is no profile of a cluster: {error}") from None


def cancel_left_behind(prefix: str) -> None:
    """Cancel the jobs that a killed workflow of this tree left in the queue.

    They would work beside their successors. What they have finished is in their journals.

    Args:
        prefix: What the names of the jobs of this tree begin with.
    """
    listed = subprocess.run(
        ["squeue", "--me", "--noheader", "--format=%i %j"],
        capture_output=True,
        text=True,
        check=True,
    )
    names = dict(line.split(maxsplit=1) for line in listed.stdout.splitlines())
    jobs = [job for job, name in names.items() if name.startswith(prefix)]
    if jobs:
        logger.warning("cancelling %d job(s) that an earlier run left behind", len(jobs))
        subprocess.run(["scancel", *jobs], check=True)

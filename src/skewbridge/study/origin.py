"""Where a file comes from, and whether the present sources and configuration would give it."""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError, SolutionError
from skewbridge.provenance.digests import source_digest
from skewbridge.provenance.stamp import read_stamp
from skewbridge.provenance.tables import provenance
from skewbridge.study.config import load_config
from skewbridge.study.keys import ANALYSIS_MODULE
from skewbridge.study.made_for import TOLD_TO

#: What the Snakefile names as its configuration, which ``--configfile`` is merged over.
_BASE_CONFIG: Final = Path("config/config.yaml")


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """Where a file comes from, and what would be made now.

    Attributes:
        told: What the file says, by name.
        now: The same where it is known for what would be made now.
        is_current: Whether the present sources and configuration would give the file.
    """

    told: dict[str, str]
    now: dict[str, str]
    is_current: bool

    @property
    def differences(self) -> list[str]:
        """Names of what is another now."""
        return [name for name, value in self.now.items() if self.told.get(name) != value]


def origin_of(path: Path, config: Path) -> Origin:
    """Return where a file of a study or of ``skewbridge run`` comes from; is it still current?

    A product of the workflow is current if its rule would make it from the same sources, motions
    and sections of the configuration; what its rule does not use may differ. A result of
    ``skewbridge run`` is current if the sources of an analysis and OpenSees are the same.

    Args:
        path: The file.
        config: Configuration, merged over that of the workflow.

    Raises:
        InputError: The file does not say where it comes from, or the workflow cannot be read.
    """
    told = read_stamp(path)
    now = {name: value for name, value in provenance().items() if name in told}
    decisive = ["openseespy_version"]
    if "rule" in told:
        found = present(config)
        rule = {"rule_digest": found["rules"].get(told["rule"], "no such rule")}
        now |= rule | {name: found[name] for name in ("config_digest", "suite_digest")}
        decisive = ["rule_digest"]
    elif "engine_digest" in told:
        now["engine_digest"] = source_digest(ANALYSIS_MODULE)
        decisive += ["engine_digest"]
    else:
        raise InputError(
            f"{path} says with which versions it was made, but not for what: it was written "
            "before results were marked with it",
            file=str(path),
        )
    is_current = all(told.get(name) == now[name] for name in decisive)
    return Origin(told=told, now=now, is_current=is_current)


def present(config: Path) -> dict[str, Any]:
    """Return what the workflow in this folder would make its products for now.

    Args:
        config: Configuration, merged over that of the workflow as ``--configfile`` does.

    Raises:
        InputError: There is no workflow here, or the configuration is bad.
        SolutionError: Snakemake cannot read the workflow.
    """
    if not Path("Snakefile").exists():
        raise InputError("no Snakefile here: call it in the folder of the study's workflow")
    load_config(config, base=_BASE_CONFIG)
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "made_for.json"
        read = subprocess.run(
            [sys.executable, "-m", "snakemake", "--list-rules", "--configfile", str(config)],
            env=os.environ | {TOLD_TO: str(output)},
            capture_output=True,
            text=True,
            check=False,
        )
        if not output.exists():
            last = (read.stderr.strip().splitlines() or ["no message"])[-1]
            raise SolutionError(f"the workflow can't be read with {config}: {last}")
        return json.loads(output.read_text(encoding="utf-8"))

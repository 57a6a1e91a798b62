"""Finished analyses of a long study, one line each: one that was broken off goes on from there."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skewbridge.analysis.keys import input_digest
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.motions.record import GroundMotion
from skewbridge.provenance.digests import digest_of, opensees_version, source_digest
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


def analysis_key(
    variant: Variant, motion: GroundMotion, settings: AnalysisSettings, options: ModelOptions
) -> str:
    """Return the digest of all that an analysis depends on, the engine's sources too."""
    given = input_digest(variant, motion, settings, options)
    return digest_of(given, source_digest(analyse.__module__), opensees_version())


class Finished:
    """Rows by key, kept in a file of JSON lines.

    Args:
        path: The file; None keeps nothing beyond this run.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self.rows: dict[str, dict[str, Any]] = {}
        if path is None or not path.exists():
            return
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:  # cut short by a kill: that analysis runs again
                continue
            self.rows[row.pop("key")] = row

    def add(self, key: str, row: Mapping[str, Any]) -> None:
        """Keep the row of a key."""
        self.rows[key] = dict(row)
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as lines:
                # the newline in front closes a line that a kill cut short
                lines.write("\n" + json.dumps({"key": key, **row}) + "\n")

"""Finished analyses of a long study, one line each: one that was broken off goes on from there."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


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
            with self._path.open("a", encoding="utf-8") as lines:
                # the newline in front closes a line that a kill cut short
                lines.write("\n" + json.dumps({"key": key, **row}) + "\n")

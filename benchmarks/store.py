"""Finished cases of a long measurement, one JSON line each: what is there is not repeated."""

import json
from pathlib import Path
from typing import Any


class Store:
    """Rows by key in a file that only grows.

    Args:
        path: The file.
        any_key: Whether the last row of the same case will do where the key is not there.
    """

    def __init__(self, path: Path, *, any_key: bool = False) -> None:
        self._path, self._any_key = path, any_key
        self._rows: dict[str, dict[str, Any]] = {}
        self._by_case: dict[str, dict[str, Any]] = {}
        for line in path.read_text("utf-8").splitlines() if path.exists() else ():
            try:
                found = json.loads(line)
            except json.JSONDecodeError:  # a line cut off when the run was killed
                continue
            self._keep(found["key"], found["row"])

    def get(self, key: str, case: str = "") -> dict[str, Any] | None:
        """Return the row of a key, or None."""
        found = self._rows.get(key)
        return self._by_case.get(case) if found is None and self._any_key else found

    def put(self, key: str, row: dict[str, Any]) -> None:
        """Keep a row."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, "row": row}) + "\n")
        self._keep(key, row)

    def _keep(self, key: str, row: dict[str, Any]) -> None:
        self._rows[key] = row
        self._by_case[row["case"]] = row

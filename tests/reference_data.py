"""Small reference files in `tests/data`, each with its source."""

import json
from functools import cache
from pathlib import Path

import pandas as pd

DATA = Path(__file__).parent / "data"


@cache
def reference_table(name):
    return pd.read_csv(DATA / f"{name}.csv", comment="#")


def fragility_case(name):
    found = json.loads((DATA / "fragility_cases.json").read_text(encoding="utf-8"))[name]
    return found["input"], found["expected"]

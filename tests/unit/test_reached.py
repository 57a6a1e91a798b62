"""Nothing in the package that no command, no rule, no benchmark and no page reaches."""

import tomllib
from pathlib import Path

from vulture import Vulture

ROOT = Path(__file__).parents[2]
KINDS = {"function", "class", "method", "property"}
VALIDATORS = ["@model_validator", "@field_validator"]


def test_every_function_is_reached() -> None:
    """Tests do not count as users; what is listed in pyproject.toml waits for its command."""
    allowed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["vulture"]
    search = Vulture(
        ignore_names=allowed["ignore_names"],
        ignore_decorators=VALIDATORS,
    )
    search.scavenge([str(ROOT / name) for name in allowed["paths"]])
    rules = "".join(path.read_text() for path in (ROOT / "workflow").rglob("*.smk"))
    unused = [
        f"{Path(item.filename).relative_to(ROOT)}: {item.name}"
        for item in search.get_unused_code(min_confidence=60)
        if item.typ in KINDS and item.name not in rules
    ]
    assert not unused

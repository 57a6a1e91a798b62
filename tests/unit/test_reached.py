"""Every function is used by a command, rule, benchmark or page."""

import re
import tomllib
from pathlib import Path

from vulture import Vulture

ROOT = Path(__file__).parents[2]
KINDS = {"function", "class", "method", "property"}
# Called by pydantic and by the command line, which find them by their decorators.
REGISTERED = ["@model_validator", "@field_validator", "@*.command"]


def test_every_function_is_reached() -> None:
    """Tests do not count as users; what is listed in pyproject.toml waits for its command."""
    allowed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["vulture"]
    search = Vulture(
        ignore_names=allowed["ignore_names"],
        ignore_decorators=REGISTERED,
    )
    search.scavenge([str(ROOT / name) for name in allowed["paths"]])
    # Rules are no Python files; registry and conf.py name functions in texts.
    named = [
        ROOT / "docs/conf.py",
        ROOT / "workflow/Snakefile",
        *(ROOT / "workflow").rglob("*.smk"),
        ROOT / "src/skewbridge/verification/registry.py",
    ]
    words = set(re.findall(r"\w+", "".join(path.read_text() for path in named)))
    unused = [
        f"{Path(item.filename).relative_to(ROOT)}: {item.name}"
        for item in search.get_unused_code(min_confidence=60)
        if item.typ in KINDS and item.name not in words
    ]
    assert not unused

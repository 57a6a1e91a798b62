"""What one source file says: what it imports, and its meaning without prose; remembered in a file.

Reading all sources as syntax trees takes longer than all else that a workflow does before it runs.
What they say depends on their bytes alone, so that it can be kept by the digest of the bytes.
"""

import ast
import hashlib
import json
import re
import sys
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

#: Arguments that are only shown: a new label changes figures and pages, and no number.
SHOWN_ARGUMENTS: Final = frozenset({"label", "symbol", "description", "title"})
#: The file is begun anew when it holds this much, most of it of sources as they were.
_LARGEST_BYTES: Final = 4_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceContent:
    """What a source file says.

    Attributes:
        names: Dotted names inside the package that it imports or names in a text.
        meaning: Digest of its syntax tree without docstrings, comments and text only shown.
        meaning_shown: The same with the text that is only shown.
    """

    names: tuple[str, ...]
    meaning: str
    meaning_shown: str


class SourceMemory:
    """Reads sources, those that it has read before from a file.

    Args:
        path: The file; None remembers for this process only.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._known = {} if path is None else _remembered(path)
        # Another reader, or another Python, may read the same bytes in another way.
        self._reader = Path(__file__).read_bytes() + sys.version.encode()

    def content(self, source: bytes, package: str) -> SourceContent:
        """Return what a source file says.

        Raises:
            SyntaxError: It is no Python.
            ValueError: It uses a relative import.
        """
        key = hashlib.sha256(b"\n".join((self._reader, package.encode(), source))).hexdigest()
        if key not in self._known:
            self._known[key] = _content(source, package)
            if self._path is not None:
                _remember(self._path, key, self._known[key])
        return self._known[key]


def _remembered(path: Path) -> dict[str, SourceContent]:
    known: dict[str, SourceContent] = {}
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            path.unlink()
        lines = path.read_bytes().splitlines()
    except OSError:
        return known
    for line in lines:
        with suppress(ValueError, TypeError, KeyError):  # cut short by a kill
            told = json.loads(line)
            key, names = told.pop("key"), tuple(told.pop("names"))
            known[key] = SourceContent(names=names, **told)
    return known


def _remember(path: Path, key: str, content: SourceContent) -> None:
    line = f"\n{json.dumps({'key': key, **asdict(content)})}\n"
    with suppress(OSError), path.open("a", encoding="utf-8") as file:
        file.write(line)


def _content(source: bytes, package: str) -> SourceContent:
    names = _imported_names(ast.parse(source), package)
    return SourceContent(
        names=tuple(sorted(names)),
        meaning=_meaning(source, shown=False),
        meaning_shown=_meaning(source, shown=True),
    )


def _imported_names(tree: ast.Module, package: str) -> set[str]:
    """Return the dotted names inside the package that a module imports or names in a text."""
    spelled = re.compile(rf"({package}(?:\.\w+)+)(\.?)(?::\w+)?")
    names: set[str] = set()
    queue: list[ast.AST] = [tree]
    while queue:
        node = queue.pop()
        if isinstance(node, ast.If) and _for_types_only(node.test):
            queue += node.orelse
            continue
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            if node.level or node.module is None:
                raise ValueError("relative imports are not followed: import by the full name")
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = spelled.fullmatch(node.value)
            names |= {f"{text[1]}.*"} if text else set()
        queue += ast.iter_child_nodes(node)
    return {name for name in names if name.split(".")[0] == package}


def _for_types_only(test: ast.expr) -> bool:
    name = test.id if isinstance(test, ast.Name) else getattr(test, "attr", "")
    return name == "TYPE_CHECKING"


def _meaning(source: bytes, *, shown: bool) -> str:
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                node.body = node.body[1:] or [ast.Pass()]
        elif isinstance(node, ast.Call) and not shown:
            node.keywords = [each for each in node.keywords if each.arg not in SHOWN_ARGUMENTS]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()

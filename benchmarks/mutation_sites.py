"""Small changes of a source file, each of which at least one test should notice."""

import ast
from bisect import bisect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import accumulate
from typing import Final

_COMPARED: Final[dict[type[ast.cmpop], tuple[str, str]]] = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}
_COMPUTED: Final[dict[type[ast.operator], tuple[str, str]]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.Pow: ("**", "*"),
    ast.FloorDiv: ("//", "/"),
}
_NAMES: Final = {
    "min": "max",
    "max": "min",
    "minimum": "maximum",
    "maximum": "minimum",
    "any": "all",
    "all": "any",
    "sin": "cos",
    "cos": "sin",
}
#: Arguments and calls whose values are only displayed or logged.
_SHOWN_ARGUMENTS: Final = frozenset({"label", "symbol", "description", "title"})
_LOGGED: Final = frozenset({"debug", "info", "warning", "error", "exception"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutation:
    """One change of the text of a module.

    Attributes:
        file: The module below the package.
        where: Name of the enclosing function or class; empty at the top level of the module.
        line: Line where it starts, from 1.
        start: Byte where the replaced text starts.
        end: Byte after the replaced text.
        old: The replaced text.
        new: The new text.
        was: The line without the change.
        becomes: The line with the change.
        in_function: Whether the change is executed in a function call, not on import.
    """

    file: str
    where: str
    line: int
    start: int
    end: int
    old: str
    new: str
    was: str
    becomes: str
    in_function: bool

    @property
    def name(self) -> str:
        """Description of the change, independent of the line number."""
        return f"{self.file} {self.where or 'module'}: {self.was}  ->  {self.becomes}"

    def applied(self, source: bytes) -> bytes:
        """Return the source with the change."""
        return source[: self.start] + self.new.encode() + source[self.end :]


def mutations(file: str, source: bytes) -> list[Mutation]:
    """Return every change of a module, ordered by position.

    The changes affect comparisons, sums and products, signs, `and`, `or`, `not`, numbers, truth
    values and the names of a few functions, but not displayed text (labels, messages) and not
    annotations. Changes that are not valid Python are left out.
    """
    texts = source.splitlines(keepends=True)
    starts = list(accumulate(map(len, texts), initial=0))

    def place(node: ast.expr) -> tuple[int, int]:
        end_line, end = node.end_lineno or node.lineno, node.end_col_offset or 0
        return starts[node.lineno - 1] + node.col_offset, starts[end_line - 1] + end

    found: list[Mutation] = []
    for node, where, in_function in _expressions(ast.parse(source)):
        for start, end, new in _changes(node, source, place):
            at = bisect(starts, start) - 1
            before, behind = source[starts[at] : start].decode(), source[end : starts[at + 1]]
            change = Mutation(
                file=file,
                where=where,
                line=at + 1,
                start=start,
                end=end,
                old=source[start:end].decode(),
                new=new,
                was=texts[at].decode().strip(),
                becomes=f"{before}{new}{behind.decode()}".strip(),
                in_function=in_function,
            )
            try:
                ast.parse(change.applied(source))
            except SyntaxError:
                continue
            found.append(change)
    return sorted(found, key=lambda each: (each.start, each.end, each.new))


def _expressions(tree: ast.AST) -> Iterator[tuple[ast.expr, str, bool]]:
    """Yield each evaluated expression, its enclosing name, and whether it is in a function."""
    queue: list[tuple[ast.AST, str, bool]] = [(tree, "", False)]
    while queue:
        node, where, inside = queue.pop()
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            where = f"{where}.{node.name}".lstrip(".")
            children = [(child, where, True) for child in node.body]
            if isinstance(node, ast.ClassDef):
                children = [(child, where, inside) for child in node.body]
            else:
                children += [(child, where, inside) for child in node.args.defaults]
                children += [(child, where, inside) for child in node.args.kw_defaults if child]
            queue += children
            continue
        if isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr) or _is_message(node):
            continue
        if isinstance(node, ast.expr):
            yield node, where, inside
        if isinstance(node, ast.AnnAssign):
            queue += [(node.value, where, inside)] if node.value else []
            continue
        if isinstance(node, ast.Lambda):
            inside = True
        queue += [(child, where, inside) for child in ast.iter_child_nodes(node)]


def _is_message(node: ast.AST) -> bool:
    if isinstance(node, ast.keyword):
        return node.arg in _SHOWN_ARGUMENTS
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and isinstance(node.func.value, ast.Name)
        and node.func.value.id == "logger"
        and node.func.attr in _LOGGED
    )


def _changes(
    node: ast.expr, source: bytes, place: Callable[[ast.expr], tuple[int, int]]
) -> Iterator[tuple[int, int, str]]:
    """Yield start, end and new text of every change of one expression, without its parts."""

    def swapped(pair: tuple[str, str] | None, left: ast.expr, right: ast.expr):
        old, new = pair or ("", "")
        at = source.find(old.encode(), place(left)[1], place(right)[0])
        if pair and at >= 0:
            yield at, at + len(old), new

    start, end = place(node)
    match node:
        case ast.Compare(left=left, ops=[operator], comparators=[right]):
            yield from swapped(_COMPARED.get(type(operator)), left, right)
        case ast.BinOp(left=left, op=operator, right=right):
            yield from swapped(_COMPUTED.get(type(operator)), left, right)
        case ast.BoolOp(op=operator, values=[left, right, *_]):
            pair = ("and", "or") if isinstance(operator, ast.And) else ("or", "and")
            yield from swapped(pair, left, right)
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield start, place(operand)[0], " "
        case ast.Constant(value=bool() as value):
            yield start, end, repr(not value)
        case ast.Constant(value=int() as value):
            yield start, end, repr(value + 1)
        case ast.Constant(value=float() as value):
            yield start, end, repr(1.2 * value if value else 1.0)
        case ast.Call(func=ast.Name() | ast.Attribute() as called, args=[_, *_]):
            name = called.id if isinstance(called, ast.Name) else called.attr
            stop = place(called)[1]
            if name in _NAMES:
                yield stop - len(name), stop, _NAMES[name]
            elif name == "abs":
                yield stop - len(name), stop, ""
        case _:
            return

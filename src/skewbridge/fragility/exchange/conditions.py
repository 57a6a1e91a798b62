"""Conditions on the rows of a table: comparisons of columns and values, nothing else.

The text is read as a syntax tree and only comparisons, ``and``, ``or``, ``not``, ``in``, names of
columns and literal values are followed: a condition can neither call nor write anything.
"""

import ast
import operator
import warnings
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.reading import shortened

MAX_LENGTH: Final = 1000
MAX_DIGITS: Final = 30
_ADVICE: Final = "it may only compare columns with values, joined by and, or, not"
_COMPARE: Final[dict[type[ast.cmpop], Callable[[Any, Any], Any]]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
type Flags = NDArray[np.bool_]


def rows_where(table: pd.DataFrame, condition: str) -> pd.DataFrame:
    """Return the rows that meet a condition such as ``skew_deg == 30 and status != 'ok'``.

    Raises:
        InputError: The text is no such condition, names no column, compares numbers with text, or
            no row meets it.
    """
    told = f"--where {shortened(condition)}"
    if len(condition) > MAX_LENGTH:
        raise InputError(f"{told}: {len(condition)} characters, at most {MAX_LENGTH} are read")
    try:
        with warnings.catch_warnings():  # of numbers that run into words
            warnings.simplefilter("ignore", SyntaxWarning)
            tree = ast.parse(condition.strip(), mode="eval")
        chosen = table[_flags(tree.body, table)]
    except (SyntaxError, RecursionError, MemoryError):
        raise InputError(f"{told} is no condition: {_ADVICE}") from None
    except ValueError as error:
        raise InputError(f"{told}: {error}") from None
    if chosen.empty:
        raise InputError(f"{told} selects no row of {len(table)}")
    return chosen


def _flags(node: ast.expr, table: pd.DataFrame) -> Flags:
    """Return which rows meet a part of a condition."""
    if isinstance(node, ast.BoolOp):
        parts = [_flags(value, table) for value in node.values]
        join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return np.asarray(join.reduce(parts), dtype=bool)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return ~_flags(node.operand, table)
    if isinstance(node, ast.Compare):
        sides = [node.left, *node.comparators]
        flags = [
            _compared(sides[place], sign, sides[place + 1], table)
            for place, sign in enumerate(node.ops)
        ]
        return np.asarray(np.logical_and.reduce(flags), dtype=bool)
    if isinstance(node, ast.Name) and pd.api.types.is_bool_dtype(_column(node.id, table)):
        return _column(node.id, table).to_numpy(dtype=bool)
    raise ValueError(_ADVICE)


def _compared(left: ast.expr, sign: ast.cmpop, right: ast.expr, table: pd.DataFrame) -> Flags:
    one = _value(left, table)
    if isinstance(sign, ast.In | ast.NotIn):
        if not isinstance(right, ast.List | ast.Tuple | ast.Set) or not isinstance(one, pd.Series):
            raise ValueError("in needs a column before it and a list of values after it")
        values = [_literal(item) for item in right.elts]
        for value in values:
            _refuse_mixed(one, value)
        inside = one.isin(values).to_numpy(dtype=bool)
        return inside if isinstance(sign, ast.In) else ~inside
    other = _value(right, table)
    if not (isinstance(one, pd.Series) or isinstance(other, pd.Series)):
        raise ValueError("a comparison needs a column")
    compare = _COMPARE.get(type(sign))
    if compare is None:
        raise ValueError(_ADVICE)
    _refuse_mixed(one, other)
    met = pd.Series(compare(one, other))
    return met.fillna(value=False).to_numpy(dtype=bool)


def _value(node: ast.expr, table: pd.DataFrame) -> Any:
    return _column(node.id, table) if isinstance(node, ast.Name) else _literal(node)


def _column(name: str, table: pd.DataFrame) -> pd.Series:
    if name not in table.columns:
        raise ValueError(f"there is no column {shortened(name)}")
    return table[name]


def _literal(node: ast.expr) -> float | str | bool:
    """Return a number, a text or True or False."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = _literal(node.operand)
        if isinstance(node.operand, ast.Constant) and not isinstance(value, str | bool):
            return -value
    elif isinstance(node, ast.Constant) and isinstance(node.value, str | bool | float | int):
        if isinstance(node.value, int) and abs(node.value) >= 10**MAX_DIGITS:
            raise ValueError(f"a number of over {MAX_DIGITS} digits")
        return node.value
    raise ValueError(_ADVICE)


def _refuse_mixed(one: Any, other: Any) -> None:
    """Refuse a comparison of text with a number, which no row can meet."""
    if _is_text(one) != _is_text(other):
        raise ValueError("compares text with a number")


def _is_text(value: Any) -> bool:
    if isinstance(value, pd.Series):
        return not (pd.api.types.is_numeric_dtype(value) or pd.api.types.is_bool_dtype(value))
    return isinstance(value, str)

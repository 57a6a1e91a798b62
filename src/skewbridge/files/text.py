"""Read text, YAML, JSON and CSV files within size limits, check values, write atomically."""

import csv
import io
import json
import os
import re
import socket
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from itertools import chain
from pathlib import Path
from stat import S_ISREG
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, NoReturn, cast

import yaml
from pydantic import BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import ArgsKwargs

from skewbridge.errors import InputError, did_you_mean, listed

if TYPE_CHECKING:
    import pandas as pd

LONGEST_SHOWN: Final = 80  # characters of a value in a message
LONGEST_PATH: Final = 200
MAX_YAML_BYTES: Final = 200_000  # the largest YAML file of the project has 12 000
MAX_JSON_BYTES: Final = 16_000_000
MAX_CSV_BYTES: Final = 64_000_000
MAX_VALUES: Final = 20_000  # of a YAML file: nested aliases make 10^9 values of a few lines
MAX_DIGITS: Final = 30  # digits of an integer; 64 bits need 19
# numbers that YAML 1.1 reads to base 8, 2, 16 or 60, such as 025 (21) and 1:30 (90)
_OTHER_BASES: Final = re.compile(r"[-+]?(0[0-9a-fA-F_bx]+$|[0-9_]+:)")
# source: OWASP, CSV injection: first characters of cells that spreadsheets take for formulas
_FORMULA_STARTS: Final = ("=", "+", "-", "@", "\t", "\r")


def shortened(value: object) -> str:
    """Return the `repr` of a value for a message, shortened and without control characters."""
    text = repr(value)
    return printable(text if len(text) <= LONGEST_SHOWN else f"{text[: LONGEST_SHOWN - 3]}...")


def shown_path(path: Path) -> str:
    """Return a path for a message. A long path is shortened at its start."""
    text = printable(str(path))
    return text if len(text) <= LONGEST_PATH else f"...{text[3 - LONGEST_PATH :]}"


def printable(text: str) -> str:
    """Return a text with each control character replaced by a question mark."""
    return "".join(character if character.isprintable() else "?" for character in text)


def file_fault(path: Path, problem: str, **details: object) -> InputError:
    """Return an `InputError` whose message is the path, then ``problem`` (starts with a blank)."""
    return InputError(f"{shown_path(path)}{problem}", file=str(path), **details)


def read_bytes(path: Path, max_bytes: int) -> bytes:
    """Return the content of a file; `InputError` above `max_bytes` bytes or if unreadable."""
    try:
        file_state = path.stat()
        is_read = S_ISREG(file_state.st_mode) and file_state.st_size <= max_bytes
        content = path.read_bytes() if is_read else b""
    except (OSError, ValueError) as error:  # a path with a zero byte is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise file_fault(path, f" cannot be read: {reason}") from None
    if not S_ISREG(file_state.st_mode):
        raise file_fault(path, " is a folder or device, but a file is needed")
    if not is_read:
        raise file_fault(path, f" has {file_state.st_size} bytes, but at most {max_bytes} are read")
    return content


def read_text(path: Path, max_bytes: int) -> str:
    """Return UTF-8 text without byte order mark. An `InputError` names the line of a bad byte."""
    content = read_bytes(path, max_bytes)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        problem = f"byte 0x{content[error.start]:02x} is not UTF-8 text: save the file as UTF-8"
        raise file_fault(path, f", line {line}: {problem}", line=line) from None


class _Loader(yaml.SafeLoader):
    """YAML loader for plain values only: dates are read as text, other tags are rejected."""

    yaml_constructors: ClassVar[Any] = {
        None: yaml.SafeLoader.construct_undefined,
        **{
            f"tag:yaml.org,2002:{kind}": getattr(yaml.SafeLoader, f"construct_yaml_{kind}")
            for kind in ("null", "bool", "int", "float", "str", "seq", "map")
        },
        "tag:yaml.org,2002:timestamp": yaml.SafeLoader.construct_yaml_str,
    }


def parse_yaml(text: str, where: str, **details: object) -> Any:
    """Return the plain value of a YAML text, or None if it is empty.

    `InputError` (with `where`, the name of its source, and line) for a tag, a repeated key, a key
    that is not text, a number of too many digits, or too many values.
    """
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _check_node(node)
        return loader.construct_document(node)
    except RecursionError:
        problem, mark = "nested too deeply", None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # or a number such as 1:99:99
        problem = printable(getattr(error, "problem", None) or " ".join(str(error).split()))[:200]
        mark = getattr(error, "problem_mark", None)
    if mark is not None:
        where, details = f"{where}, line {mark.line + 1}", {**details, "line": mark.line + 1}
    raise InputError(f"{where}: not valid YAML: {problem}", **details)


def _check_node(node: Any) -> int:
    """Refuse invalid keys, long integers and too many values; return the number of values."""
    if isinstance(node, yaml.ScalarNode):
        if node.tag.endswith(":int") and len(node.value) > MAX_DIGITS:
            _refuse(node, f"a whole number may have at most {MAX_DIGITS} digits")
        if node.tag.endswith((":int", ":float")) and _OTHER_BASES.match(node.value):
            number = shortened(node.value)
            _refuse(node, f"{number} is not to base 10: omit leading zeros, or quote a text")
        return 1
    children = node.value
    if isinstance(node, yaml.MappingNode):
        _check_keys(node)
        children = [child for item in node.value for child in item]
    count = 1
    for child in children:
        count += _check_node(child)
        if count > MAX_VALUES:
            _refuse(node, f"more than {MAX_VALUES} values (an alias counts as all its values)")
    return count


def _check_keys(node: yaml.MappingNode) -> None:
    keys: set[str] = set()
    for key, _ in node.value:
        if not key.tag.endswith((":str", ":merge")):
            _refuse(key, "a key must be text: put it in quotation marks")
        if key.value in keys:
            _refuse(key, f"the key {shortened(key.value)} appears twice")
        keys.add(key.value)


def _refuse(node: Any, problem: str) -> NoReturn:
    raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file, or None if it is empty; see `parse_yaml` for errors."""
    return parse_yaml(read_text(path, MAX_YAML_BYTES), shown_path(path), file=str(path))


def read_mapping(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file ({} if empty); raises `InputError` for other content."""
    raw = {} if (content := read_yaml(path)) is None else content
    if not isinstance(raw, dict):
        raise file_fault(path, " must contain keys and values at the top level")
    return raw


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; `InputError` if unreadable, too large or invalid."""

    def distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        content = dict(pairs)
        if len(content) < len(pairs):
            names = [name for name, _ in pairs]
            repeated = next(name for name in names if names.count(name) > 1)
            raise ValueError(f"the key {shortened(repeated)} appears twice")
        return content

    text = read_text(path, MAX_JSON_BYTES)
    try:
        return json.loads(text, object_pairs_hook=distinct)
    except RecursionError:
        raise file_fault(path, " is nested too deeply") from None
    except ValueError as error:
        raise file_fault(path, f" is not valid JSON: {error}") from None


def read_csv(path: Path, **options: Any) -> "pd.DataFrame":
    """Return a CSV table with one header line; options are passed to `pandas.read_csv`.

    `InputError` (with the line) for a repeated column or a row of another length.
    """
    import pandas as pd  # here: pandas takes longer to import than everything else

    text = read_text(path, MAX_CSV_BYTES)
    try:
        width = _check_rows(text)
        options |= {"index_col": False, "skipinitialspace": True}
        return pd.read_csv(io.StringIO(text), usecols=range(width), **options)
    except (ValueError, csv.Error, OverflowError) as error:
        problem = " ".join(str(error).split())
        raise file_fault(path, f" is not a table: {problem}") from None


def _check_rows(text: str) -> int:
    """Return the number of columns of a CSV text; refuse repeated names and unequal rows."""
    rows = csv.reader(io.StringIO(text), skipinitialspace=True, strict=True)
    header = next((row for row in rows if row), None)
    if header is None:
        raise ValueError("the file is empty")
    names = [name.strip() for name in header]
    if len(names) == 1 and (mark := next((mark for mark in ";\t" if mark in names[0]), "")):
        raise ValueError(
            f"the columns {shortened(names[0])} are separated by "
            f"{'semicolons' if mark == ';' else 'tabs'}: write commas, and points in numbers"
        )
    repeated = next((name for name in names if name and names.count(name) > 1), None)
    if repeated is not None:
        raise ValueError(f"the column {shortened(repeated)} appears twice")
    for row in rows:
        if row and (len(row) < len(names) or any(cell.strip() for cell in row[len(names) :])):
            row_size = f"line {rows.line_num} has {len(row)} cells"
            raise ValueError(f"{row_size}, but the header has {len(names)}")
    return len(names)


def no_formula(value: Any) -> Any:
    """Return a cell; a text that a spreadsheet would read as a formula gets a leading ``'``."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA_STARTS) else value


@contextmanager
def written_aside(path: Path) -> Generator[Path]:
    """Yield a temporary path next to a file, and rename it to the file when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{_writer()}")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with written_aside(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def writable_folder(folder: Path) -> Path:
    """Create a folder if necessary and return it; raises `InputError` if it is not writable."""
    probe = folder / f".write-test-{_writer()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"cannot write to the folder {str(folder)!r}: {error.strerror}") from None
    return folder


def writable_file(path: Path) -> Path:
    """Create the folder of a file if necessary, check that it is writable, and return the path."""
    writable_folder(path.parent)
    if path.is_dir():
        raise InputError(f"cannot write the file {str(path)!r}: it is a folder")
    return path


def _writer() -> str:
    """Return host name and process number; process numbers may repeat on other cluster nodes."""
    return f"{socket.gethostname()}.{os.getpid()}"


# --- checks of values against a pydantic class


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True)]


def _flag(value: Any) -> Any:
    return {"true": True, "false": False}.get(value, value) if isinstance(value, str) else value


#: True or false, also as text: `snakemake --config` passes values in braces as text.
Flag = Annotated[bool, BeforeValidator(_flag), Field(strict=True)]
#: Option classes refuse unknown keys; the docstring of a field describes its key.
OPTIONS: Final = ConfigDict(extra="forbid", use_attribute_docstrings=True)
#: Path of a file or folder.
FileName = Annotated[str, Field(min_length=1, max_length=1000, pattern=r"^[^\x00-\x1f]+$")]

_UNKNOWN: Final = {"extra_forbidden", "unexpected_keyword_argument"}
_MISSING: Final = {"missing", "missing_keyword_only_argument", "missing_argument"}
_NO_KEYS: Final = {"dataclass_type", "model_type", "model_attributes_type", "dict_type"}


def checked[T](kind: type[T], raw: Any, where: str | Path) -> T:
    """Return plain values as a `kind`; `InputError` lists all errors of `where`, their source."""
    adapter = TypeAdapter(kind)
    try:
        return adapter.validate_python(raw)
    except ValidationError as error:
        errors = cast(list[dict[str, Any]], error.errors())
        findings = [finding | {"loc": _keys_of(raw, finding["loc"])} for finding in errors]
    is_unknown = any(finding["type"] in _UNKNOWN for finding in findings)
    schema = adapter.json_schema() if is_unknown else {}
    keys = list(_keys(schema, schema.get("$defs", {})))
    # a list with invalid items is not also reported as too short
    invalid_lists = {
        finding["loc"][:end] for finding in findings for end in range(len(finding["loc"]))
    }
    lines = [
        _explain(finding, keys)
        for finding in findings
        if finding["type"] != "too_short" or finding["loc"] not in invalid_lists
    ]
    raise errors_of(where, lines, **({"file": str(where)} if isinstance(where, Path) else {}))


def errors_of(where: str | Path, lines: Sequence[str], **details: object) -> InputError:
    """Return an `InputError` that lists the errors of a source; all are in its details."""
    source = shown_path(where) if isinstance(where, Path) else where
    message = f"{source}: {lines[0]}"
    if len(lines) > 1:
        message = listed(f"{source} has {len(lines)} errors:", lines)
    return InputError(message, **details, errors=lines)


def _keys_of(raw: Any, error_path: tuple[str | int, ...]) -> tuple[str | int, ...]:
    """Return the keys from the top to an error, without the types that pydantic adds in unions."""
    keys, node = list[str | int](), raw
    for step in error_path:
        parent: Any = node
        if isinstance(node, dict) and step not in node and parent.get("type") == step:
            continue
        keys.append(step)
        try:
            node = parent[step]
        except (KeyError, IndexError, TypeError):
            node = None
    return tuple(keys)


def merged(base: Mapping[str, Any], top: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with nested mappings updated from `top`; lists and values are replaced."""
    result = dict(base)
    for key, value in top.items():
        base_value: Any = result.get(key)
        are_mappings = isinstance(base_value, Mapping) and isinstance(value, Mapping)
        result[key] = merged(base_value, value) if are_mappings else value
    return result


def _keys(schema: Mapping[str, Any], classes: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """Yield all keys of a JSON schema as paths such as `motions.count`."""
    alternatives = chain.from_iterable(schema.get(word, ()) for word in ("anyOf", "allOf", "oneOf"))
    for branch in (schema, *alternatives):
        if referenced := classes.get(branch.get("$ref", "").rsplit("/", 1)[-1]):
            yield from _keys(referenced, classes, prefix)
        for key, value_schema in branch.get("properties", {}).items():
            yield prefix + key
            yield from _keys(value_schema.get("items", value_schema), classes, f"{prefix}{key}.")


def _nearest_key(error_path: Sequence[str | int], keys: Sequence[str]) -> str:
    """Return a suggestion for an unknown key: a similar one, or the same in another section."""
    *parents, name = (str(step) for step in error_path if isinstance(step, str))
    section = "".join(f"{step}." for step in parents)
    if section + name in keys:
        return " of this type"
    in_section = [key.removeprefix(section) for key in keys if key.startswith(section)]
    nearest = get_close_matches(name, [key for key in in_section if "." not in key], n=1)
    same_name = [key for key in keys if key.rpartition(".")[2] == name]
    if nearest or same_name:
        return f" (did you mean {section + nearest[0] if nearest else min(same_name, key=len)}?)"
    return did_you_mean(name, keys)


def _explain(finding: Any, keys: Sequence[str]) -> str:
    """Return one error found by pydantic as text: the key, the limit and the given value."""
    key_path = ".".join(printable(str(step)[:LONGEST_SHOWN]) for step in finding["loc"])
    kind, value = finding["type"], finding["input"]
    if kind in _UNKNOWN:
        text = f"unknown key{_nearest_key(finding['loc'], keys)}"
    elif kind in _MISSING:
        text = "is missing"
    elif kind in _NO_KEYS:
        text = "must contain keys and values"
    elif kind == "union_tag_invalid":
        key_path += f".{finding['ctx']['discriminator']}".replace("'", "")
        text = "must be one of {expected_tags}, got '{tag}'".format(**finding["ctx"])
    else:
        message = finding["msg"].removeprefix("Value error, ").replace("valid tuple", "list")
        text = re.sub(r"^(Input|Tuple|List|String) should", "must", message)
        text = re.sub(" after validation|, unable to parse string.*", "", text)
    if kind not in _UNKNOWN | _MISSING and not isinstance(value, Mapping | ArgsKwargs):
        text += f", got {shortened(value)}".removesuffix(".0")
    number = value if isinstance(value, str) and value[-1:].isdigit() else ""
    if re.search("[0-9],[0-9]", number):
        text += " (write a decimal point, and no commas in numbers)"
    elif number and kind in {"float_type", "float_parsing", "int_type"}:
        text += " (it is text. Write a number with an exponent like 2.0e+7. `snakemake --config`"
        text += " passes values within braces as text: use a file and --configfile instead)"
    return f"{key_path}: {text}" if key_path else text

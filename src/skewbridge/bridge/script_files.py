"""Script of a user's own bridge: the files that it uses, its function, and errors in its lines."""

import ast
import importlib.util
import sys
import traceback
from collections.abc import Callable, Generator, Iterator
from contextlib import chdir, contextmanager, redirect_stdout
from dataclasses import fields
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError
from skewbridge.files.digests import digest_of
from skewbridge.files.text import read_bytes, read_text
from skewbridge.variant.options import ModelOptions

FUNCTION: Final = "bridge"
_MAX_BYTES: Final = 50_000_000
#: Modelling options that act on elements of the bridge, not on its joints or its damping.
FRAME_OPTIONS: Final = frozenset({
    "bent_skew", "bent_skew_deg", "cap_load", "column_spacing", "concrete_strength_factor",
    "deck_mass_factor", "elastic_columns", "foundation", "hinge_rule", "shear_failure",
    "shear_model", "steel_strength_factor",
})  # fmt: skip
#: The same, but set by schemes and accuracies for all bridges: a script need not have them.
FRAME_NUMERICS: Final = frozenset({
    "column_fibers", "column_integration", "deck_elements_per_span", "fiber_end",
})  # fmt: skip
_OPTIONS: Final = tuple(field.name for field in fields(ModelOptions))


def script_files(path: Path) -> list[Path]:
    """Return a script, local modules that it imports, and local files that they name."""
    folder, files = path.parent, [path]
    for file in files:
        if file.suffix != ".py":
            continue
        for name in _names(file):
            candidates = (folder / name, file.parent / name, Path(name).resolve())
            files += [
                candidate.resolve()
                for candidate in dict.fromkeys(candidates)
                if candidate.resolve() not in files
                and candidate.resolve().is_relative_to(folder)
                and candidate.is_file()
            ]
    return files


def _names(file: Path) -> Iterator[str]:
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            modules = [module, *(f"{module}.{alias.name}".strip(".") for alias in node.names)]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if 0 < len(node.value) < 200 and node.value.isprintable():
                yield node.value
            continue
        else:
            continue
        for parts in (module.split(".") for module in modules if module):
            for length in range(1, len(parts) + 1):
                yield f"{'/'.join(parts[:length])}.py"
                yield f"{'/'.join(parts[:length])}/__init__.py"


def _tree(file: Path) -> ast.Module:
    try:
        return ast.parse(read_text(file, _MAX_BYTES))
    except (SyntaxError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        line = getattr(error, "lineno", 1)
        raise InputError(f"{file}:{line}: {getattr(error, 'msg', error)}", file=file.name) from None


def files_digest(files: list[Path]) -> str:
    """Return the digest of the names and contents of the files of a script."""
    folder = files[0].parent
    return digest_of(
        *(
            (file.relative_to(folder).as_posix(), sha256(read_bytes(file, _MAX_BYTES)).hexdigest())
            for file in sorted(files)
        )
    )


def parameters(path: Path) -> tuple[str, ...]:
    """Return the parameters of a script's function: the skew and modelling options."""
    for node in _tree(path).body:
        if isinstance(node, ast.FunctionDef) and node.name == FUNCTION:
            arguments = node.args
            names = tuple(argument.arg for argument in (*arguments.args, *arguments.kwonlyargs))
            for name in names:
                if name not in ("skew_deg", *_OPTIONS):
                    raise InputError(
                        f"{path}:{node.lineno}: parameter {name} of {FUNCTION}() must be skew_deg "
                        "or a key of the section model"
                    )
            return names
    raise InputError(
        f"{path}: a script of a bridge must have a function {FUNCTION}() that builds "
        "the model and returns a skewbridge.Frame"
    )


def call_script(files: list[Path], arguments: dict[str, Any]) -> Any:
    """Import a script and its modules anew, call its function and return the result."""
    path, paths = files[0], {str(file) for file in files}

    def forget() -> None:
        for name, module in list(sys.modules.items()):
            if getattr(module, "__file__", None) in paths:
                del sys.modules[name]

    spec = importlib.util.spec_from_file_location(f"{path.stem}_script", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: the script is not a Python file")
    forget()
    sys.path.insert(0, str(path.parent))
    # bytecode hides an edit of equal size within a second
    writes_none, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        # its prints are no answer of a command, and later paths are from the same folder
        with lines_of(files), redirect_stdout(sys.stderr), chdir(Path.cwd()):
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            function: Callable[..., Any] = getattr(module, FUNCTION)
            return function(**arguments)
    finally:
        sys.dont_write_bytecode = writes_none
        sys.path.remove(str(path.parent))
        forget()


@contextmanager
def lines_of(files: list[Path]) -> Generator[None]:
    """Turn an error in a script into an `InputError` that names its file and line."""
    try:
        yield
    except (Exception, SystemExit) as error:
        if isinstance(error, InputError) and "file" in error.details:
            raise
        paths = {str(file) for file in files}
        steps = [
            step for step in traceback.extract_tb(error.__traceback__) if step.filename in paths
        ]
        location = f"{steps[-1].filename}:{steps[-1].lineno}" if steps else str(files[0])
        text = f"{error}" if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        if type(error).__name__ == "OpenSeesError":
            text = f"OpenSees refuses {steps[-1].line if steps else 'a command'}"
        raise InputError(f"{location}: {text}", file=files[0].name) from error

"""Mutation tests: small changes of the sources, each of which should make a test fail.

    benchmarks/mutants.py                the sample; resumes after an interruption
    benchmarks/mutants.py --again        only the survivors, with the current tests
    benchmarks/mutants.py --table FILE   no runs: the kill rate and every survivor, as a page

The sources are changed in a copy (results/mutants/tree). A change runs the tests that reach its
line, the shortest first, then the other tests of their files, for at most FIRST_S seconds (AGAIN_S
with --again); the first failure ends it. The lines that each test reaches are measured once, and
again for edited tests (`reached_lines.py`; after edits of the sources remove
results/mutants/reached.json).
"""

import argparse
import ast
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import pytest
import yaml
from mutation_sites import Mutation, mutations

ROOT: Final = Path(__file__).parents[1]
WORK: Final = ROOT / "results" / "mutants"
TREE: Final = WORK / "tree"
REACHED: Final = WORK / "reached.json"
FOUND: Final = WORK / "mutants.jsonl"
PACKAGES: Final = ("contact", "bridge", "analysis", "demands", "fragility", "motions")
TESTS: Final = ("tests/unit", "tests/property", "tests/verification", "tests/faults")
SEED: Final = 20261122
COUNT: Final = 200
FIRST_S: Final = 15.0
AGAIN_S: Final = 60.0
#: Changes without effect on results (`equivalent`), and survivors with a reason (`left`).
JUDGED: Final = Path(__file__).with_name("mutants_judged.yaml")
_HEAD: Final = """# Mutation tests

`make mutants` makes {total} small changes to the sources, one at a time (`<` to `<=`, `+` to `-`, a
number, a sign, `min` to `max`, ...), drawn with a fixed seed, and runs the tests that reach the
changed line until one fails: for up to {first_s:g} s, survivors again for up to {again_s:g} s.
Slow tests and those of the workflow are left out. Finished changes are not repeated.
"""
_LIBRARIES: Final = (
    "hypothesis",
    "joblib",
    "matplotlib.figure",
    "openseespy.opensees",
    "pandas",
    "pyarrow.parquet",
    "pydantic.dataclasses",
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "seaborn",
    "typer.testing",
)
_HOUR_S: Final = 3600
_WAITING: Final = 20
_NO_TESTS: Final = 5
_USAGE: Final = 4


def sample() -> list[Mutation]:
    """Return the sample in random order: its first n changes are also a random sample."""
    package = ROOT / "src" / "skewbridge"
    files = [file for name in PACKAGES for file in sorted((package / name).rglob("*.py"))]
    every = [
        change
        for file in files
        for change in mutations(file.relative_to(package).as_posix(), file.read_bytes())
    ]
    # by digest, so that an edit of one module does not change the choice among the others
    return sorted({each.name: each for each in every}.values(), key=_drawn)[:COUNT]


def _drawn(change: Mutation) -> bytes:
    return hashlib.sha256(f"{SEED} {change.name}".encode()).digest()


def copy_tree() -> None:
    """Copy all files that git does not ignore, with their times: compiled files stay valid."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    ).stdout.split("\0")
    shutil.rmtree(TREE, ignore_errors=True)
    for name in filter(None, listed):
        if (ROOT / name).is_file():
            (TREE / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, TREE / name)


def run_tests(arguments: list[str], cpu_s: int) -> tuple[int | None, str]:
    """Run pytest on the copy in a child process; return exit code (None: timeout) and output.

    The child is a fork with the libraries loaded, because loading them takes longer than most
    tests. The time limit is processor time, so that a busy machine does not shorten it.
    """
    output = WORK / "output.txt"
    child = os.fork()
    if child == 0:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 5))
        signal.alarm(_WAITING * cpu_s)  # for a child that waits without computing
        with output.open("wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        os.chdir(TREE)
        sys.path.insert(0, str(TREE / "src"))
        code = pytest.main(["-p", "no:cacheprovider", "--hypothesis-seed=0", *arguments])
        sys.stdout.flush()
        os._exit(int(code))
    _, status = os.waitpid(child, 0)
    code = os.waitstatus_to_exitcode(status)
    with suppress(ProcessLookupError):  # processes left behind by a killed test
        os.killpg(child, signal.SIGKILL)
    return None if code == -signal.SIGXCPU else code, output.read_text(errors="replace")


def prepare_children() -> None:
    """Load the libraries of the tests, but not the package; let all children use the copy."""
    for name in _LIBRARIES:
        import_module(name)
    sys.dont_write_bytecode = True
    paths = os.pathsep.join([str(TREE / "src"), str(TREE / "benchmarks")])
    os.environ |= {"PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1"}


class Reach:
    """Tests that reach each line, and their durations."""

    def __init__(self, found: dict[str, Any]) -> None:
        self.seconds = {
            name: test["s"] for name, test in found["tests"].items() if "not_passed" not in test
        }
        self._of_file: dict[str, list[str]] = defaultdict(list)
        self._tests: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
        for name in self.seconds:
            test_file = name.split("::")[0]
            self._of_file[test_file].append(name)
            for file, line in [*found["tests"][name]["lines"], *found["shared"].get(test_file, [])]:
                self._tests[file][line].add(name)

    def tests(self, change: Mutation, budget_s: float) -> list[str]:
        """Return the tests to run within the budget: those that reach the change come first."""
        lines = self._tests[change.file]
        if change.in_function:
            before = [line for line in lines if line <= change.line]
            reaching = set(lines[max(before)]) if before else set()
        else:  # executed on import: any test that uses the module may notice it
            reaching = set().union(*lines.values())
        if not reaching:
            users = [file for file in self._tests if change.file in imported(file)]
            reaching = set().union(*(s for file in users for s in self._tests[file].values()))
        files = {name.split("::")[0] for name in reaching}
        others = {name for file in files for name in self._of_file[file]} - reaching
        order = [*sorted(reaching, key=self._cost), *sorted(others, key=self._cost)]
        chosen: list[str] = []
        left_s = budget_s
        for name in order:
            left_s -= self.seconds[name]
            if left_s >= 0.0 or not chosen:
                chosen.append(name)
        return chosen

    def _cost(self, name: str) -> tuple[float, str]:
        return round(self.seconds[name], 2), name


def imported(file: str) -> set[str]:
    """Return the modules that a module imports, as files below the package."""
    tree = ast.parse((TREE / "src" / "skewbridge" / file).read_bytes())
    names = [
        node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module
    ]
    return {f"{name.removeprefix('skewbridge.').replace('.', '/')}.py" for name in names}


def measured() -> dict[str, Any]:
    """Return the lines that each test reaches; only new or edited test files are measured."""
    known: dict[str, Any] = {"tests": {}, "shared": {}, "files": {}}
    if REACHED.exists():
        known = json.loads(REACHED.read_text())
    files = {
        path.relative_to(TREE).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for folder in TESTS
        for path in sorted((TREE / folder).glob("test_*.py"))
    }
    edited = [name for name, digest in files.items() if known["files"].get(name) != digest]
    if edited:
        part = WORK / "reached_part.json"
        selected = ["-p", "reached_lines", "-m", "not slow", *edited]
        os.environ["REACHED_LINES"] = str(part)
        run_tests(selected, _HOUR_S)
        found = json.loads(part.read_text())
        for kind in ("tests", "shared"):
            kept = {
                name: each
                for name, each in known[kind].items()
                if (file := name.split("::")[0]) in files and file not in edited
            }
            known[kind] = kept | found[kind]
        known["files"] = files
        REACHED.write_text(json.dumps(known))
    return known


def tried(change: Mutation, reach: Reach, budget_s: float) -> dict[str, Any]:
    """Try one change and return the result: killed, survived, or not tried with the reason."""
    tests = reach.tests(change, budget_s)
    expected_s = sum(reach.seconds[name] for name in tests)
    effort = {"tests": len(tests), "tests_s": round(expected_s, 1)}
    if not tests:
        return {"fate": "survived", "by": "no test reaches it", **effort}
    path = TREE / "src" / "skewbridge" / change.file
    source, stat = path.read_bytes(), path.stat()
    listed = WORK / "tests.txt"
    listed.write_text("\n".join(tests))
    try:
        path.write_bytes(change.applied(source))
        code, output = run_tests(["-x", "--tb=no", f"@{listed}"], round(3.0 * expected_s) + 60)
    finally:
        path.write_bytes(source)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    if code is None:
        return {"fate": "killed", "by": "timeout", **effort}
    # a test file that uses the module on import may already fail there
    if code == _USAGE and run_tests(["--collect-only", "-q", f"@{listed}"], _HOUR_S)[0] == 0:
        return {"fate": "killed", "by": "tests that cannot be loaded", **effort}
    if code in {_USAGE, _NO_TESTS, -signal.SIGALRM}:
        return {"fate": "not tried", "by": output.strip()[-300:], **effort}
    failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    by = failed[0].split(" - ")[0] if failed else f"pytest ended with {code}"
    return {"fate": "killed" if code else "survived", "by": by if code else "", **effort}


def remaining(again: bool) -> Iterator[Mutation]:
    """Yield the changes of the sample that were not tried yet, or those that survived."""
    last = {entry["mutant"]: entry["fate"] for entry in entries()}
    for change in sample():
        fate = last.get(change.name)
        if fate == "survived" if again else fate in {None, "not tried"}:
            yield change


def entries() -> list[dict[str, Any]]:
    """Return the stored results; an incomplete last line is left out."""
    lines = FOUND.read_text().splitlines(keepends=True) if FOUND.exists() else []
    return [json.loads(line) for line in lines if line.endswith("\n")]


def page(sample: list[Mutation], entries: list[dict[str, Any]]) -> str:
    """Return the results as Markdown: detected changes by package, list of undetected changes."""
    fates = {entry["mutant"]: entry for entry in entries}  # the last entry of each change
    first = {entry["mutant"]: entry["fate"] for entry in reversed(entries)}
    judged = yaml.safe_load(JUDGED.read_text()) if JUDGED.exists() else {}
    # `equivalent` or `left`, and the reason
    verdicts = {each: judged.get(each.name, "left: ").partition(": ") for each in sample}
    ran = [
        each for each in sample if fates.get(each.name, {}).get("fate") in {"killed", "survived"}
    ]
    survived = [each for each in ran if fates[each.name]["fate"] == "survived"]
    left = [each for each in survived if verdicts[each][0] != "equivalent"]
    counted = [each for each in ran if each in left or each not in survived]
    noticed = sum(first[each.name] == "killed" for each in counted)
    detected = 100.0 * (1.0 - len(left) / max(len(counted), 1))
    share = 100.0 * noticed / max(len(counted), 1)
    of_package = Counter(each.file.split("/")[0] for each in counted)
    left_of_package = Counter(each.file.split("/")[0] for each in left)
    lines = [
        _HEAD.format(total=len(sample), first_s=FIRST_S, again_s=AGAIN_S),
        f"Tried: {len(ran)} of {len(sample)}; {len(ran) - len(counted)} of them change no result "
        f"(reasons in `benchmarks/mutants_judged.yaml`). Of the other {len(counted)}, tests "
        f"detected **{len(counted) - len(left)} ({detected:.0f} %)**, and {noticed} "
        f"({share:.0f} %) at the first try.\n",
        "| package | tried | detected |",
        "| --- | ---: | ---: |",
        *(f"| `{p}` | {n} | {n - left_of_package[p]} |" for p, n in sorted(of_package.items())),
        "\n## Not detected\n",
        *(
            ["| where | is | changed to | reason |", "| --- | --- | --- | --- |"]
            if left
            else ["None."]
        ),
    ]
    for each in left:
        was, becomes = (code.replace("|", "\\|") for code in (each.was, each.becomes))
        reason = verdicts[each][2] or "no test yet"
        lines.append(f"| `{each.file}` {each.where} | `{was}` | `{becomes}` | {reason} |")
    return "\n".join([*lines, ""])


def main() -> None:
    parser = argparse.ArgumentParser(description="Run the tests on small changes of the sources.")
    parser.add_argument("--again", action="store_true", help="only changes that survived before")
    parser.add_argument("--table", type=Path, help="write the results as a page, run nothing")
    chosen = parser.parse_args()
    if chosen.table:
        chosen.table.write_text(page(sample(), entries()))
        return
    os.nice(10)
    copy_tree()
    prepare_children()
    reach = Reach(measured())
    budget_s = AGAIN_S if chosen.again else FIRST_S
    for change in remaining(chosen.again):
        entry = {"mutant": change.name, **tried(change, reach, budget_s)}
        with FOUND.open("a") as file:
            file.write(json.dumps(entry) + "\n")
        sys.stdout.write(f"{entry['fate']:9} {entry['mutant']}  {entry['by']}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()

"""Helpers of the benchmarks: cases, options, interleaved ratios, output."""

import argparse
import json
import platform
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any, Final

from scipy.stats import binomtest

from skewbridge.bridge.library import load_structure
from skewbridge.motions.folder import list_motions
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.motions.levels import BLOCK
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite, read_entry
from skewbridge.study.config import CONDITIONING_BRIDGE
from skewbridge.variant.variant import Variant

ROOT: Final = Path(__file__).parents[1]
MOTIONS: Final = ROOT / "motions"
RESULTS: Final = ROOT / "results" / "benchmarks"
FRICTION_PCT: Final = 50
_PACKAGES: Final = ("openseespy", "numpy", "scipy", "pandas", "joblib", "pydantic")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One variant under one scaled motion."""

    variant: Variant
    motion: GroundMotion
    window_s: float | None = None

    @property
    def name(self) -> str:
        """Variant, motion and window."""
        window = "whole" if self.window_s is None else f"{self.window_s:g}s"
        return f"{self.variant.slug} {self.motion.motion_id} {window}"


def suite_motion(motion_id: str, window_s: float | None = None) -> GroundMotion:
    """Return a motion of the shipped suite at its factor, whole or cut to its strongest part."""
    entry = next(entry for entry in list_motions(MOTIONS) if entry.motion_id == motion_id)
    motion = read_entry(entry).scaled(_factors()[motion_id])
    return motion if window_s is None else cut_to_strongest(motion, window_s, 0.0)


@cache
def _factors() -> dict[str, float]:
    """Return the factors of the first block of motions, as a study of osb1 computes them."""
    suite = prepare_suite(MOTIONS, count=BLOCK, t1_s=load_structure(CONDITIONING_BRIDGE).t1_s)
    return dict(zip(suite["motion_id"], suite["scale"], strict=True))


def osb1(skew_deg: int, gap_mm: int, friction_pct: int = FRICTION_PCT) -> Variant:
    """Return a variant of the bridge that all benchmarks use."""
    return Variant(
        bridge="osb1",
        abutment="contact_friction",
        skew_deg=skew_deg,
        gap_mm=gap_mm,
        friction_pct=friction_pct,
    )


def options(description: str | None, **defaults: Any) -> argparse.Namespace:
    """Return the options of the command line; each has the type of its default.

    An option with the default None is a number, one with False a flag; tuples take several values.
    """
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, default in defaults.items():
        flag = f"--{name.replace('_', '-')}"
        if isinstance(default, bool):
            parser.add_argument(flag, action="store_true")
        elif isinstance(default, tuple):
            parser.add_argument(flag, nargs="+", default=default, type=type(default[0]))
        else:
            kind = float if default is None else type(default)
            parser.add_argument(flag, default=default, type=kind)
    return parser.parse_args()


def show(found: Any) -> None:
    """Print a result as JSON."""
    sys.stdout.write(json.dumps(found, indent=1) + "\n")
    sys.stdout.flush()


def best_of(action: Callable[[], object], repeats: int) -> float:
    """Return the shortest of several wall times in s."""
    times: list[float] = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def cpu_s[T](work: Callable[[], T]) -> tuple[T, float]:
    """Return the result of a call and its processor time (s)."""
    start_s = time.process_time()
    found = work()
    return found, time.process_time() - start_s


def interleaved(works: Mapping[str, Callable[[], float]], repeats: int) -> dict[str, list[float]]:
    """Return repeated measures by name, taken in turn so that a busy machine slows all alike."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats):
        for name, work in works.items():
            found[name].append(work())
    return found


def ratio(above: Sequence[float], below: Sequence[float]) -> dict[str, float]:
    """Return median, range and count of the ratios of two series of measures."""
    return spread([a / b for a, b in zip(above, below, strict=True)])


def spread(values: Sequence[float]) -> dict[str, float]:
    """Return median, smallest, largest and number of values."""
    return {
        "median": median(values),
        "least": min(values),
        "largest": max(values),
        "count": len(values),
    }


def share_of(hits: Sequence[bool]) -> tuple[float, float, float]:
    """Return the share of hits with the exact 95 % bounds of its probability (Clopper, Pearson)."""
    interval = binomtest(sum(hits), len(hits)).proportion_ci(0.95)
    return sum(hits) / len(hits), float(interval.low), float(interval.high)


def versions() -> dict[str, Any]:
    """Return the versions of Python and packages."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        **{package: version(package) for package in _PACKAGES},
    }

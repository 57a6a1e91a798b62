"""What the benchmarks share: cases, interleaved ratios, versions."""

import argparse
import platform
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any, Final

from skewbridge.motions.conditioning import cut_to_strongest
from skewbridge.motions.index import list_motions
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import read_entry
from skewbridge.variant.variant import Variant

ROOT: Final = Path(__file__).parents[1]
MOTIONS: Final = ROOT / "motions"
RESULTS: Final = ROOT / "results" / "benchmarks"
FRICTION_PCT: Final = 50
_PACKAGES: Final = ("openseespy", "numpy", "scipy", "pandas", "joblib", "pydantic")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One variant under one motion, which has its factor in it."""

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
    motion = read_entry(entry).scaled(entry.scale)
    return motion if window_s is None else cut_to_strongest(motion, window_s, 0.0)


def osb1(skew_deg: int, gap_mm: int, friction_pct: int = FRICTION_PCT) -> Variant:
    """Return a variant of the bridge that everything is measured on."""
    return Variant(
        bridge="osb1",
        abutment="contact_friction",
        skew_deg=skew_deg,
        gap_mm=gap_mm,
        friction_pct=friction_pct,
    )


def add_case_arguments(parser: argparse.ArgumentParser) -> None:
    """Let a command name one case."""
    parser.add_argument("--motion", default="syn002", help="motion of the shipped suite")
    parser.add_argument("--skew-deg", type=int, default=30)
    parser.add_argument("--gap-mm", type=int, default=51)
    parser.add_argument("--friction-pct", type=int, default=FRICTION_PCT)
    parser.add_argument("--window-s", type=float, help="the whole motion by default")


def case_from(given: argparse.Namespace) -> Case:
    """Return the case that the arguments name."""
    return Case(
        variant=osb1(given.skew_deg, given.gap_mm, given.friction_pct),
        motion=suite_motion(given.motion, given.window_s),
        window_s=given.window_s,
    )


def cpu_s[T](work: Callable[[], T]) -> tuple[T, float]:
    """Return what a call gives, and its processor time."""
    start_s = time.process_time()
    found = work()
    return found, time.process_time() - start_s


def interleaved(works: Mapping[str, Callable[[], float]], repeats: int) -> dict[str, list[float]]:
    """Return the measures of some repeats, taken in turn so that a busy machine hits all alike."""
    found: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats):
        for name, work in works.items():
            found[name].append(work())
    return found


def ratio(above: Sequence[float], below: Sequence[float]) -> dict[str, float]:
    """Return median and range of the ratios of measures taken in turn."""
    return spread([a / b for a, b in zip(above, below, strict=True)])


def spread(values: Sequence[float]) -> dict[str, float]:
    """Return median, least and largest, and how many."""
    return {
        "median": median(values),
        "least": min(values),
        "largest": max(values),
        "count": len(values),
    }


def versions() -> dict[str, Any]:
    """Return what the numbers were measured with."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        **{package: version(package) for package in _PACKAGES},
    }

"""Synthetic motions and suites for a user's scenario, and the shipped suites.

The default suite has 128 pairs with 20 s of shaking and 5 s of zeros. The first 40 are stored
as files; the index has the numbers of the others, which are generated where a study needs them.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions import intensity
from skewbridge.motions.folder import INDEX_NAME, index_row, write_index
from skewbridge.motions.formats import at2_text, write_at2
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.synthesis import ddk18
from skewbridge.motions.synthesis.bssa14 import calibrate_pair, target_spectrum
from skewbridge.units import G_MPS2

DT_S: Final = 0.01
SOURCE: Final = "synthetic: model of Dabaghi and Der Kiureghian (2018)"
_GOLDEN_SHARE: Final = 0.5 * (np.sqrt(5.0) - 1.0)
# ASSUME one strong strike-slip earthquake near the bridge on firm soil: its median Sa_avg is the
# middle of the default levels (0.07 to 2.25 g), which keeps scale factors near 1.
SCENARIO: Final = ddk18.Scenario(magnitude=6.5, distance_km=8.0, vs30_mps=400.0)
SEED: Final = 2023
# ASSUME motions that shake much longer than the window are left out: the others keep nearly all
# of their Arias intensity, but the suite has no motions of the longest durations.
MIN_ARIAS_KEPT: Final = 0.95
STEPS_PER_G: Final = 1.0e7  # values of a generated motion are multiples of 1e-7 g
# The values of a motion differ by 1e-14 g between processors, measured with and without the vector
# instructions of numpy and OpenBLAS.
CLEAR_OF_TIES_G: Final = 1.0e-12
MAX_COUNT: Final = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class SuiteRule:
    """Rule of a shipped suite; the first `stored` motions are files; `letters` begin all names."""

    scenario: ddk18.Scenario
    count: int
    stored: int = 0
    shaking_s: float = 20.0
    letters: str = "syn"


_FAR: Final = ddk18.Scenario(magnitude=7.5, distance_km=30.0, vs30_mps=400.0)
_PULSE: Final = ddk18.Scenario(magnitude=7.0, distance_km=5.0, vs30_mps=400.0, pulse="all")
#: The shipped suites. ``far`` has long shaking from the largest distance that the model covers.
#: Every motion of ``pulse`` has a forward-directivity pulse in a random direction, so that the
#: suites do not differ by direction.
SUITES: Final = {
    "near": SuiteRule(scenario=SCENARIO, count=128, stored=40),
    "far": SuiteRule(scenario=_FAR, count=16, shaking_s=45.0, letters="far"),
    "pulse": SuiteRule(scenario=_PULSE, count=16, shaking_s=25.0, letters="pulse"),
}


def synthesize(
    scenario: ddk18.Scenario,
    *,
    index: int,
    seed: int,
    calibrate: Literal["bssa14", "none"] = "bssa14",
    orientation: Literal["random", "principal"] = "random",
    turn_pulses: bool = False,
    dt_s: float = DT_S,
) -> GroundMotion:
    """Return one synthetic motion, determined by scenario, options, seed and index (from 0).

    The random stream is ``SeedSequence([seed, index])``. The calibration ``bssa14`` matches the
    medians and dispersions of spectra to that model. The orientation ``random`` rotates each pair
    about the vertical, so that the stronger principal component is not always along the bridge. A
    pair with a pulse (in component 1) is rotated only if ``turn_pulses`` is true. The orientation
    ``principal`` keeps the stronger component as component 1.
    """
    parameters, rng = drawn_parameters(scenario, index=index, seed=seed)
    pulse = parameters.pulse
    one_g, two_g, start_s = ddk18.simulate_background(parameters, scenario.magnitude, rng, dt_s)
    if calibrate == "bssa14":
        target_g = target_spectrum(scenario, seed, index)
        corner_hz = ddk18.corner_frequency_hz(scenario.magnitude)
        one_g, two_g = calibrate_pair(one_g, two_g, dt_s, target_g, corner_hz)
    if pulse is not None:
        time_s = np.arange(one_g.size, dtype=np.float64) * dt_s - start_s
        one_g = one_g + ddk18.pulse_acceleration(pulse, time_s)
    if orientation == "random" and (pulse is None or turn_pulses):
        # ASSUME all directions of the principal axes are equally likely
        angle_rad = np.pi * ((index + 1) * _GOLDEN_SHARE % 1.0)
        cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
        one_g, two_g = cosine * one_g - sine * two_g, sine * one_g + cosine * two_g
    kind = scenario.mechanism if pulse is None else f"{scenario.mechanism}, pulse"
    site = {name: getattr(scenario, name) for name in ("magnitude", "distance_km", "vs30_mps")}
    return GroundMotion(
        motion_id=f"syn{index + 1:03d}",
        dt_s=dt_s,
        accel_1_mps2=one_g * G_MPS2,
        accel_2_mps2=two_g * G_MPS2,
        event=f"DDK18 M{scenario.magnitude:g} {kind}",
        **site,
        station=f"seed {seed}, number {index + 1}",
        source=SOURCE,
    )


def drawn_parameters(
    scenario: ddk18.Scenario, *, index: int, seed: int
) -> tuple[ddk18.ModelParameters, np.random.Generator]:
    """Return the parameters of one motion, and the random generator after drawing them."""
    if seed < 0 or index < 0:
        raise InputError(f"seed and index must not be negative, got {seed} and {index}")
    rng = np.random.default_rng(np.random.SeedSequence([seed, index]))
    rng.uniform()  # unused, but without this draw all motions would change
    return ddk18.draw_parameters(scenario, rng), rng


def default_motions(
    count: int | None = None, suite: str = "near"
) -> Iterator[tuple[int, GroundMotion, bool]]:
    """Yield the first `count` motions of a shipped suite (None: all).

    Each item is the number in the stream of the seed (from 1), the motion, and whether it is stored
    in files; `made_motion` generates other motions. No motion depends on the count.
    """
    rule = SUITES[suite]
    motions = number = 0
    while motions < (rule.count if count is None else count):
        number += 1
        is_stored = motions < rule.stored
        if not is_stored:
            parameters, _ = drawn_parameters(rule.scenario, index=number - 1, seed=SEED)
            if not all(map(ddk18.meets_its_times, parameters.components)):
                continue
        uncut, cut = _synthesized(number, rule)
        share = intensity.pair_arias_build_up(cut)[-1] / intensity.pair_arias_build_up(uncut)[-1]
        if share >= MIN_ARIAS_KEPT and (is_stored or _is_clear_of_ties(cut)):
            motions += 1
            yield number, cut if is_stored else _rounded(cut), is_stored


def made_motion(number: int, suite: str = "near") -> GroundMotion:
    """Return a generated motion of a shipped suite, with the digest that its files would have.

    The digest and the keys of analyses are the same on every processor, although the last digits of
    exp, sin and the Fourier transform differ. To achieve this, values are rounded to multiples of
    1e-7 g, and the suite has only motions with exact envelopes (`meets_its_times`) in which a
    difference of 1e-12 g can't change the rounding of a value.
    """
    motion = _rounded(_synthesized(number, SUITES[suite])[1])
    text = "".join(at2_text(motion, component) for component in (1, 2))
    return replace(motion, sha256=hashlib.sha256(text.encode("ascii")).hexdigest())


def write_default_suite(folder: Path, suite: str = "near") -> int:
    """Write `index.csv` and `synthetic/*.AT2` of a shipped suite; return the number of motions."""
    rows: list[dict[str, object]] = []
    for number, cut, is_stored in default_motions(suite=suite):
        files = write_at2(cut, folder / "synthetic") if is_stored else ()
        rows.append(_row(cut if files else made_motion(number, suite), files, folder))
        if not files:
            rows[-1]["made_from_number"] = number
            rows[-1] |= {} if suite == "near" else {"made_from_suite": suite}
    write_index(folder / INDEX_NAME, rows)
    return len(rows)


def write_synthetic_suite(folder: Path, scenario: ddk18.Scenario, *, count: int, seed: int) -> Path:
    """Write pairs as PEER files, replace the `index.csv` of the folder, and return its path.

    Pair i of a seed does not depend on the count. Quiet ends are cut. Raises `InputError` for a
    count outside its limits.
    """
    if not 1 <= count <= MAX_COUNT:
        raise InputError(f"count must be between 1 and {MAX_COUNT}, got {count}")
    rows: list[dict[str, object]] = []
    for index in range(count):
        motion = intensity.trim_quiet_ends(synthesize(scenario, index=index, seed=seed))
        rows.append(_row(motion, write_at2(motion, folder), folder))
    write_index(folder / INDEX_NAME, rows)
    return folder / INDEX_NAME


def _synthesized(number: int, rule: SuiteRule) -> tuple[GroundMotion, GroundMotion]:
    """Return a motion of the stream, first uncut and then cut to its strongest part."""
    uncut = synthesize(rule.scenario, index=number - 1, seed=SEED, turn_pulses=True)
    uncut = replace(uncut, motion_id=f"{rule.letters}{number:03d}")
    return uncut, intensity.cut_to_strongest(uncut, rule.shaking_s, free_vibration_s=5.0)


def _rounded(motion: GroundMotion) -> GroundMotion:
    # Adding zero makes a negative zero positive: its sign depends on the processor.
    return motion.mapped(
        lambda accel: (np.rint(accel / G_MPS2 * STEPS_PER_G) + 0.0) / STEPS_PER_G * G_MPS2
    )


def _is_clear_of_ties(motion: GroundMotion) -> bool:
    """Return whether every processor rounds all values the same way."""
    steps = np.concatenate(motion.components) / G_MPS2 * STEPS_PER_G
    from_tie_g = np.abs(steps - np.floor(steps) - 0.5) / STEPS_PER_G
    return bool(from_tie_g.min() > CLEAR_OF_TIES_G)


def _row(motion: GroundMotion, files: tuple[Path, ...], folder: Path) -> dict[str, object]:
    """Return the index row of a synthetic motion that is stored in two files or in none."""
    return index_row(motion, files, folder) | {"unit": "g", "licence": "BSD-3-Clause"}

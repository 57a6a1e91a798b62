"""Write a synthetic suite of a user's scenario: waveforms and index."""

from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.motions.conditioning import add_free_vibration, cut_to_strongest, trim_quiet_ends
from skewbridge.motions.synthesis.embedded import synthetic_row
from skewbridge.motions.synthesis.generate import SynthesisOptions, synthesize
from skewbridge.motions.synthesis.scenario import Scenario
from skewbridge.motions.write import write_at2, write_index

MAX_COUNT: Final = 1000


def write_synthetic_suite(
    folder: Path,
    scenario: Scenario,
    *,
    count: int,
    seed: int,
    options: SynthesisOptions,
    shaking_s: float | None = None,
    free_vibration_s: float = 0.0,
) -> Path:
    """Write pairs as PEER files with an `index.csv`; return the path of the index.

    Args:
        folder: Where to write; an index in it is replaced.
        scenario: Earthquake and site.
        count: Number of pairs.
        seed: Seed; pair i is the same whatever the count.
        options: Calibration, orientation, time step.
        shaking_s: Keep only the strongest part of this length; None cuts only the quiet ends.
        free_vibration_s: Zeros added at the end.

    Raises:
        InputError: A count or length outside its limits, an unwritable folder.
    """
    if not 1 <= count <= MAX_COUNT:
        raise InputError(f"count must be within 1 to {MAX_COUNT}, got {count}")
    rows: list[dict[str, object]] = []
    for index in range(count):
        motion = synthesize(scenario, index=index, seed=seed, options=options)
        if shaking_s is None:
            motion = add_free_vibration(trim_quiet_ends(motion), free_vibration_s)
        else:
            motion = cut_to_strongest(motion, shaking_s, free_vibration_s)
        rows.append(synthetic_row(motion, write_at2(motion, folder), folder))
    index_path = folder / "index.csv"
    write_index(index_path, rows)
    return index_path

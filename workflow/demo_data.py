"""Store a finished study for `skewbridge demo`: `python workflow/demo_data.py RESULTS`."""

import shutil
import sys
from pathlib import Path

from PIL import Image

from skewbridge.cli.study import DEMO_STUDY
from skewbridge.study.folder import StudyFolder

COLOURS = 32  # per stored picture; more than the figures use


def store(results: Path, stored: Path = DEMO_STUDY) -> None:
    """Replace the stored study by the tables of the page and its pictures with few colours."""
    shutil.rmtree(stored, ignore_errors=True)
    study = StudyFolder(results)
    for path in study.report_inputs.values():
        copy = stored / path.relative_to(results)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
    (stored / "figures").mkdir()
    for path in sorted(study.figures.glob("*.png")):
        with Image.open(path) as picture:
            few = picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
            few.save(stored / "figures" / path.name, optimize=True)


if __name__ == "__main__":
    store(Path(sys.argv[1]))

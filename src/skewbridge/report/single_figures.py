"""Single figures of a finished study, drawn again from its tables."""

from collections.abc import Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path

from skewbridge.errors import InputError
from skewbridge.reading import shortened
from skewbridge.report.figure_files import Drawing, save_figure
from skewbridge.report.study_figures import Caption, read_tables, study_figures
from skewbridge.study.figure_settings import FigureSettings
from skewbridge.study.folder import StudyFolder


def finished_figures(results: Path) -> list[tuple[Caption, Drawing]]:
    """Return the figures of a finished study with what draws them; none is drawn yet.

    Args:
        results: Folder of the study.

    Raises:
        InputError: A table that they need is not there.
    """
    folder = StudyFolder(results)
    paths = {
        "demands": folder.demands,
        "curves": folder.fragility("curves"),
        "effects": folder.fragility("effects"),
        "suite": folder.suite,
        "friction_pair": folder.friction_pair,
    }
    for path in paths.values():
        if not path.is_file():
            raise InputError(f"{path} is missing: run the study to its end first", file=str(path))
    choices = folder.modelling_choices if folder.modelling_choices.is_file() else None
    return list(study_figures(read_tables(paths, choices)))


def draw_figures(
    figures: Sequence[tuple[Caption, Drawing]],
    names: Sequence[str],
    settings: FigureSettings,
    folder: Path,
) -> list[Path]:
    """Draw the named figures of a study as SVG and PNG.

    Args:
        figures: Those of the study.
        names: Names of figures, with ``*`` for any text.
        settings: Width and font.
        folder: Where the files go.

    Returns:
        The files.

    Raises:
        InputError: A name fits no figure; nothing is drawn then.
    """
    known = [caption.name for caption, _ in figures]
    for name in names:
        if not any(fnmatchcase(each, name) for each in known):
            like = get_close_matches(name, known, n=3) or known[:3]
            told = f"no figure has the name {shortened(name)}; among them are {', '.join(like)}"
            raise InputError(f"{told}; skewbridge plot lists all")
    wanted = [
        (caption.name, draw)
        for caption, draw in figures
        if any(fnmatchcase(caption.name, name) for name in names)
    ]
    written: list[Path] = []
    for name, draw in wanted:
        written += save_figure(draw, settings, folder, name)
    return written

"""Commands for ground motions: check, measure, draw, synthesize."""

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final, Literal

from skewbridge.cli import COMMANDS, new_group
from skewbridge.cli.options import OUT
from skewbridge.cli.output import Answer, Arg, Opt, command, messages, warn
from skewbridge.errors import EXIT_BAD_INPUT, InputError
from skewbridge.files.text import writable_file

commands = new_group()
motions = new_group(name="motions", help=COMMANDS["motions"][1])
commands.add_typer(motions)

#: Fields of `motions.formats.Given`, for files without a time step or a unit.
_GIVEN: Final = (
    Opt("dt_s_if_missing", float | None, "Time step for files without one.", flags="--dt-s"),
    Opt("unit_if_missing", str | None, "Unit for files without one.", None, "[g|cm/s2|m/s2|...]",
        "--unit"),
)  # fmt: skip


@command(
    motions,
    Arg("paths", list[Path], "Files, or folders with motions.", ...),
    *_GIVEN,
    Opt("strict", bool, "Treat warnings as errors.", False),
    Opt("write", bool, "Write or update the index of each folder.", False),
)
def check(paths: list[Path], strict: bool, write: bool, **given: Any) -> Answer:
    """Read motion files and report errors and warnings; exits with 2 if a file is unusable.

    Files of a folder that are not read are listed; with --strict the exit code is then 2.

    Example: skewbridge motions check motions/
    """
    from skewbridge.motions.check import check_paths, write_folder_index
    from skewbridge.motions.formats import Given

    if write:
        for folder in paths:
            if folder.is_dir():
                messages.print(f"wrote {write_folder_index(folder, Given(**given))}")
    checks = check_paths(paths, Given(**given), strict=strict)
    unread = [item for item in checks if item.verdict in ("not_read", "left_out")]
    if unread:
        warn(f"{len(unread)} files were not read: {', '.join(item.file for item in unread)}")
    is_strict = strict and any(item.verdict == "not_read" for item in unread)
    code = 0 if all(item.passes for item in checks) and not is_strict else EXIT_BAD_INPUT
    files = {"files": [asdict(item) for item in checks]}
    return Answer({**files, "not_read": len(unread)}, shown=files, exit_code=code)


@command(
    motions,
    Arg("files", list[Path], "Component files.", ...),
    Opt("t1_s", float | None, "Conditioning period in s, for Sa(T1) and Sa_avg."),
    Opt("period_s", list[float] | None, "Period of the spectra in s; repeatable."),
    *_GIVEN,
)
def im(files: list[Path], t1_s: float | None, period_s: list[float] | None, **given: Any) -> Answer:
    """Compute intensity measures of one component or of a pair of components.

    Example: skewbridge motions im A.AT2 B.AT2 --t1-s 0.75
    """
    from skewbridge.motions.formats import Given
    from skewbridge.motions.intensity import measures_and_spectra
    from skewbridge.motions.read import read_components

    if not 1 <= len(files) <= 2:
        raise InputError(f"motions im takes one or two files, got {len(files)}")
    _, dt_s, components, notes = read_components(files, Given(**given))
    for note in notes:
        messages.print(note)
    return Answer(measures_and_spectra(components, dt_s, t1_s, period_s))


@command(
    motions, Arg("paths", list[Path], "One or two components, or a folder.", ...), OUT, *_GIVEN
)
def plot(paths: list[Path], out: Path, **given: Any) -> Answer:
    """Draw a record with its spectra, or the spectra of a folder of motions.

    Example: skewbridge motions plot A.AT2 B.AT2 --out record.png
    """
    from skewbridge.motions.formats import Given
    from skewbridge.motions.read import read_components
    from skewbridge.motions.suite import folder_spectra
    from skewbridge.report.motion_figures import record_page, suite_spectra

    if len(paths) == 1 and paths[0].is_dir():
        name = paths[0].resolve().name
        figure = suite_spectra(**folder_spectra(paths[0]), title=name)
    elif len(paths) <= 2:
        name, step_s, components, _ = read_components(paths, Given(**given))
        labelled = dict(zip((path.name for path in paths), components, strict=True))
        figure = record_page(name, step_s, labelled)
    else:
        raise InputError(f"motions plot takes one or two files or a folder, got {len(paths)}")
    path = out if out.suffix.lower() in {".png", ".svg", ".pdf"} else out / f"{name}.png"
    figure.savefig(writable_file(path), dpi=150)
    return Answer({"file": str(path)})


@command(
    motions,
    OUT,
    Opt("magnitude", float, "Moment magnitude, 6.5 to 7.9.", ...),
    Opt("distance_km", float, "Distance to the rupture, up to 31 km.", ...),
    Opt("vs30_mps", float, "Mean shear-wave velocity of the upper 30 m.", ...),
    Opt("mechanism", Literal["strike_slip", "reverse"], "Mechanism.", "strike_slip"),
    Opt("ztor_km", float, "Depth to the top of the rupture.", 0.0),
    Opt("pulse", Literal["none", "all"], "Motions that have a pulse.", "none"),
    Opt("rupture_to_site_km", float, "Rupture length towards the site, for pulses.", 20.0),
    Opt("count", int, "Number of pairs.", 40),
    Opt("seed", int, "Seed of the suite.", 1),
    Opt("calibrate", Literal["bssa14", "none"], "Ground-motion model of the spectra.", "bssa14"),
    Opt("orientation", Literal["random", "principal"], "Orientation of the components.", "random"),
    Opt("shaking_s", float | None, "Length of the strongest part to use, in s."),
    Opt("free_vibration_s", float, "Length of zeros added at the end, in s.", 0.0),
)
def synthesize(out: Path, **given: Any) -> Answer:
    """Synthesize pairs of motions with the model of Dabaghi and Der Kiureghian (2018).

    Example: skewbridge motions synthesize --magnitude 7 --distance-km 10 --vs30-mps 400 --out mine
    """
    from skewbridge.motions.synthesis.ddk18 import Scenario
    from skewbridge.motions.synthesis.generate import write_synthetic_suite

    scenario = Scenario(**{name: given.pop(name) for name in Scenario.__slots__ if name in given})
    index = write_synthetic_suite(out, scenario, **given)
    return Answer({"count": given["count"], "index": str(index)})


@command(
    motions,
    OUT,
    Opt("suite", Literal["near", "far", "pulse"], "Shipped suite to write.", "near"),
)
def default_suite(out: Path, suite: str) -> Answer:
    """Regenerate a shipped suite of motions.

    Example: skewbridge motions default-suite --out suite
    """
    from skewbridge.motions.synthesis.generate import write_default_suite

    return Answer({"count": write_default_suite(out, suite)})

"""Commands for ground motions: check, measure, draw, synthesize, select."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from skewbridge.cli import COMMANDS, new_group
from skewbridge.cli.output import Answer, Changes, Out, arg, command, keys_and_values, opt
from skewbridge.errors import EXIT_BAD_INPUT, InputError
from skewbridge.files.text import writable_file
from skewbridge.units import Units

if TYPE_CHECKING:
    from skewbridge.motions.formats import Stated

commands = new_group()
motions = new_group(name="motions", help=COMMANDS["motions"][1])
commands.add_typer(motions)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingOptions:
    """Time step and unit for motion files that state none."""

    dt_s: Annotated[float | None, opt("Time step in s for files without one.")] = None
    unit: Annotated[str | None, opt("Unit for files without one.", "[g|cm/s2|m/s2|...]")] = None

    @property
    def given(self) -> "Stated":
        """Time step and unit for files that state none."""
        from skewbridge.files.text import checked
        from skewbridge.motions.formats import Stated

        stated = {"dt_s_if_missing": self.dt_s, "unit_if_missing": self.unit}
        return checked(Stated, stated, "--dt-s, --unit")


@command(motions)
def check(
    paths: Annotated[list[Path], arg("Files, or folders with motions.")],
    missing: MissingOptions,
    strict: Annotated[bool, opt("Treat warnings as errors.", None, "--strict")] = False,
    write: Annotated[bool, opt("Write index.csv into each folder.", None, "--write")] = False,
) -> Answer:
    """Read motion files and report errors and warnings; exits with 2 if a file is unusable.

    Files of a folder that are not read are listed; with --strict the exit code is then 2.

    Example: skewbridge motions check motions/
    """
    from skewbridge.motions.check import check_paths, write_folder_index

    stated = missing.given
    folders = [path for path in paths if write and path.is_dir()]
    notes = [f"wrote {write_folder_index(folder, stated)}" for folder in folders]
    checks = check_paths(paths, stated, strict=strict)
    unread = [item.file for item in checks if item.verdict in ("not_read", "left_out")]
    warnings = [f"{len(unread)} files were not read: {', '.join(unread)}"] if unread else []
    is_usable = all(item.passes and (item.verdict != "not_read" or not strict) for item in checks)
    files = {"files": [asdict(item) for item in checks]}
    code = 0 if is_usable else EXIT_BAD_INPUT
    answer = {**files, "not_read": len(unread)}
    return Answer(answer, files, notes=notes, exit_code=code, warnings=warnings)


@command(motions)
def im(
    files: Annotated[list[Path], arg("Component files.")],
    missing: MissingOptions,
    t1_s: Annotated[float | None, opt("Conditioning period in s, for Sa(T1) and Sa_avg.")] = None,
) -> Answer:
    """Compute intensity measures of one component or of a pair of components.

    Files without a time step or unit take it from the `index.csv` beside them or from the options.

    Example: skewbridge motions im A.AT2 B.AT2 --t1-s 0.75
    """
    from skewbridge.motions.intensity import measures_and_spectra
    from skewbridge.motions.suite import read_components

    if not 1 <= len(files) <= 2:
        raise InputError(f"motions im takes one or two files, got {len(files)}")
    _, step_s, components, notes = read_components(files, missing.given)
    measures = measures_and_spectra(components, step_s, t1_s)
    return Answer(measures, notes=notes, missing="needs --t1-s")


@command(motions)
def plot(
    paths: Annotated[list[Path], arg("One or two components, or a folder.")],
    missing: MissingOptions,
    out: Out,
    units: Units,
) -> Answer:
    """Draw a record with its spectra, or the spectra of a folder of motions.

    Example: skewbridge motions plot A.AT2 B.AT2 --out record.png
    """
    from skewbridge.motions.suite import read_components
    from skewbridge.report.appearance import shown_in
    from skewbridge.report.run_figures import folder_spectra, record_page

    notes: tuple[str, ...] = ()
    if len(paths) == 1 and paths[0].is_dir():
        name = paths[0].resolve().name
        figure = folder_spectra(paths[0], title=name)
    elif len(paths) <= 2:
        name, step_s, components, notes = read_components(paths, missing.given)
        by_file_name = dict(zip((path.name for path in paths), components, strict=True))
        with shown_in(units):
            figure = record_page(name, step_s, by_file_name)
    else:
        raise InputError(f"motions plot takes one or two files or a folder, got {len(paths)}")
    path = out if out.suffix.lower() in {".png", ".svg", ".pdf"} else out / f"{name}.png"
    figure.savefig(writable_file(path), dpi=150)
    return Answer({"file": str(path)}, notes=notes)


@command(motions)
def synthesize(
    out: Out,
    magnitude: Annotated[float, opt("Moment magnitude, 6.5 to 7.9.")],
    distance_km: Annotated[float, opt("Distance to the rupture, up to 31 km.")],
    vs30_mps: Annotated[float, opt("Mean shear-wave velocity of the upper 30 m.")],
    count: Annotated[int, opt("Number of pairs.")] = 40,
    seed: Annotated[int, opt("Seed of the suite.")] = 1,
) -> Answer:
    """Synthesize pairs of motions with the model of Dabaghi and Der Kiureghian (2018).

    The earthquake is strike-slip, and the motions have no pulse; `motions.synthesis` has others.

    Example: skewbridge motions synthesize --magnitude 7 --distance-km 10 --vs30-mps 400 --out mine
    """
    from skewbridge.motions.synthesis import Scenario, write_synthetic_suite

    scenario = Scenario(magnitude=magnitude, distance_km=distance_km, vs30_mps=vs30_mps)
    index = write_synthetic_suite(out, scenario, count=count, seed=seed)
    return Answer({"count": count, "index": str(index)})


@command(motions)
def select(
    target: Annotated[Path, opt("YAML file, or disaggregation of OpenQuake or the USGS.", "FILE")],
    sources: Annotated[list[Path], opt("Candidates: folder or p695; repeatable.", "DIR", "--from")],
    out: Out,
    count: Annotated[int, opt("Number of pairs at each level.")] = 30,
    changes: Changes = None,  # keys of the target
    without: Annotated[Path | None, opt("Earlier selection: leave its pairs out.", "DIR")] = None,
) -> Answer:
    """Select and scale pairs that follow the conditional spectrum of each level.

    Example: skewbridge motions select --target target.yaml --from p695 --from mine --out selected
    """
    import numpy as np

    from skewbridge.motions.selection import BAND_POINTS, select_motions
    from skewbridge.report.run_figures import suite_spectra

    keys = keys_and_values("--set", changes)
    selections = select_motions(target, keys, sources, count, out, without)
    band = slice(BAND_POINTS)
    for number, (spectrum, pairs, _) in enumerate(selections, start=1):
        model = ("target", spectrum.median_g[band], spectrum.sigma[band])
        title = f"{target.name}, level {number}: {spectrum.causes['level_g']:.3g} g"
        psa_g = np.exp(np.stack(pairs["log_psa"].to_list()))
        figure = suite_spectra(psa_g, spectrum.periods_s[band], title=title, model=model)
        figure.savefig(out / f"level_{number}.png", dpi=150)
    levels = [selection.summary for selection in selections]
    warnings = [doubt for selection in selections for doubt in selection.doubts]
    return Answer({"levels": levels, "index": str(out / "index.csv")}, warnings=warnings)

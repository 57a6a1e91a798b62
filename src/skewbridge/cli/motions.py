"""Commands for ground motions: check, measure, draw, synthesize."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from skewbridge.cli.options import Opt, takes
from skewbridge.cli.output import Command, JsonOption, emit, messages, new_group
from skewbridge.errors import EXIT_BAD_INPUT, InputError
from skewbridge.files.text import writable_file

if TYPE_CHECKING:
    from skewbridge.motions.formats import Given

commands = new_group()
motions = new_group("motions", "Read, check, measure, draw and synthesize ground motions.")
commands.add_typer(motions)

Files = Annotated[list[Path], typer.Argument(help="Component files.")]
DtOption = Annotated[float | None, typer.Option("--dt-s", help="Time step for files without one.")]
UnitOption = Annotated[
    str | None,
    typer.Option("--unit", help="Unit for files without one.", metavar="[g|cm/s2|m/s2]"),
]
OutOption = Annotated[Path, typer.Option("--out", help="Folder to write to.")]


@motions.command(cls=Command)
def check(
    paths: Annotated[list[Path], typer.Argument(help="Files, or folders with motions.")],
    dt_s: DtOption = None,
    unit: UnitOption = None,
    *,
    strict: Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")] = False,
    write: Annotated[
        bool, typer.Option("--write", help="Write or update the index of each folder.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Read motion files and report errors and warnings; exits with 2 if a file is unusable.

    Example: skewbridge motions check motions/
    """
    from skewbridge.motions.check import check_paths, write_folder_index

    given = _given(dt_s, unit)
    if write:
        for folder in paths:
            if folder.is_dir():
                messages.print(f"wrote {write_folder_index(folder, given)}")
    checks = check_paths(paths, given, strict=strict)
    rows = [
        {
            "file": Path(item.file).name,
            "verdict": item.verdict,
            "format": item.format or "",
            "dt (s)": item.dt_s or "",
            "values": item.npts or "",
            "PGA (g)": item.pga_g or "",
            "messages": "; ".join(item.messages),
        }
        for item in checks
    ]
    emit({"files": [asdict(item) for item in checks]}, rows, as_json=as_json)
    if not all(item.passes for item in checks):
        raise typer.Exit(EXIT_BAD_INPUT)


@motions.command(cls=Command)
def im(
    files: Files,
    t1_s: Annotated[
        float | None, typer.Option(help="Conditioning period, for Sa(T1) and Sa_avg.")
    ] = None,
    period_s: Annotated[list[float] | None, typer.Option(help="Periods of the spectra.")] = None,
    dt_s: DtOption = None,
    unit: UnitOption = None,
    *,
    as_json: JsonOption = False,
) -> None:
    """Compute intensity measures of a pair of components, or of one.

    Example: skewbridge motions im A.AT2 B.AT2 --t1-s 0.75
    """
    from skewbridge.motions.summary import component_summary, pair_summary

    if len(files) == 2:
        answer = pair_summary(files[0], files[1], _given(dt_s, unit), t1_s, period_s)
    elif len(files) == 1:
        answer = component_summary(files[0], _given(dt_s, unit), t1_s, period_s)
    else:
        raise InputError(f"motions im takes one or two files, got {len(files)}")
    for message in answer.pop("messages"):
        messages.print(message)
    emit(answer, as_json=as_json)


@motions.command(cls=Command)
def plot(
    paths: Annotated[list[Path], typer.Argument(help="One or two components, or a folder.")],
    out: OutOption,
    dt_s: DtOption = None,
    unit: UnitOption = None,
    *,
    as_json: JsonOption = False,
) -> None:
    """Draw a record with its spectra, or the spectra of a folder of motions.

    Example: skewbridge motions plot A.AT2 B.AT2 --out record.png
    """
    from skewbridge.motions.summary import read_components, suite_table
    from skewbridge.report.motion_figures import record_page, suite_spectra

    if len(paths) == 1 and paths[0].is_dir():
        name = paths[0].resolve().name
        table = suite_table(paths[0])
        figure = suite_spectra(table.rotd50_g, table.periods_s, title=name, model=table.model)
    elif len(paths) <= 2:
        name, step_s, components = read_components(paths, _given(dt_s, unit))
        figure = record_page(name, step_s, components)
    else:
        raise InputError(f"motions plot takes one or two files or a folder, got {len(paths)}")
    path = out if out.suffix.lower() in {".png", ".svg", ".pdf"} else out / f"{name}.png"
    figure.savefig(writable_file(path), dpi=150)
    emit({"file": str(path)}, as_json=as_json)


@motions.command(cls=Command)
@takes(
    Opt("magnitude", float, "Moment magnitude, 6.5 to 7.9.", ...),
    Opt("distance_km", float, "Distance to the rupture, up to 31 km.", ...),
    Opt("vs30_mps", float, "Mean shear-wave velocity of the upper 30 m.", ...),
    Opt("mechanism", Literal["strike_slip", "reverse"], "Mechanism.", "strike_slip"),
    Opt("ztor_km", float, "Depth to the top of the rupture.", 0.0),
    Opt("pulse", Literal["none", "all", "probability"], "Motions with a pulse.", "none"),
    Opt("rupture_to_site_km", float, "Rupture length towards the site, for pulses.", 20.0),
)
def synthesize(
    out: OutOption,
    *,
    count: Annotated[int, typer.Option(help="Number of pairs.")] = 40,
    seed: Annotated[int, typer.Option(help="Seed of the suite.")] = 1,
    calibrate: Annotated[
        Literal["bssa14", "none"], typer.Option(help="Ground-motion model that the spectra follow.")
    ] = "bssa14",
    orientation: Annotated[
        Literal["random", "principal"], typer.Option(help="Orientation of the components.")
    ] = "random",
    shaking_s: Annotated[
        float | None, typer.Option(help="Keep the strongest part of this length.")
    ] = None,
    free_vibration_s: Annotated[float, typer.Option(help="Zeros added at the end.")] = 0.0,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Synthesize pairs of motions by the model of Dabaghi and Der Kiureghian (2018).

    Example: skewbridge motions synthesize --magnitude 7 --distance-km 10 --vs30-mps 400 --out mine
    """
    from skewbridge.motions.synthesis.ddk18 import Scenario
    from skewbridge.motions.synthesis.generate import SynthesisOptions, write_synthetic_suite

    index = write_synthetic_suite(
        out,
        Scenario(**given),
        count=count,
        seed=seed,
        options=SynthesisOptions(calibrate=calibrate, orientation=orientation),
        shaking_s=shaking_s,
        free_vibration_s=free_vibration_s,
    )
    emit({"count": count, "index": str(index)}, as_json=as_json)


@motions.command(cls=Command)
def default_suite(
    out: OutOption,
    suite: Annotated[
        Literal["near", "far", "pulse"], typer.Option(help="Shipped suite to write.")
    ] = "near",
    t1_s: Annotated[
        float | None, typer.Option(help="Conditioning period; that of osb1 if not given.")
    ] = None,
    *,
    as_json: JsonOption = False,
) -> None:
    """Write a shipped suite again, with its scale factors.

    Example: skewbridge motions default-suite --out suite
    """
    import numpy as np

    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.motions.synthesis.generate import write_default_suite
    from skewbridge.study.config import CONDITIONING_BRIDGE

    period_s = load_bridge(CONDITIONING_BRIDGE).t1_s if t1_s is None else t1_s
    effects = write_default_suite(out, period_s, suite)
    rows = [
        {
            "ratio after cutting": name,
            "lowest": min(effect[name] for effect in effects),
            "geometric mean": float(np.exp(np.mean(np.log([e[name] for e in effects])))),
            "highest": max(effect[name] for effect in effects),
        }
        for name in effects[0]
    ]
    title = f"{len(effects)} motions, T1 = {period_s:g} s"
    emit({"count": len(effects), "t1_s": period_s, "cut": rows}, rows, as_json=as_json, title=title)


def _given(dt_s: float | None, unit: str | None) -> "Given":
    from skewbridge.motions.formats import Given

    return Given(dt_s_if_missing=dt_s, unit_if_missing=unit)

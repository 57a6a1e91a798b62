"""`skewbridge bridge`: a bridge of one's own before any study."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, emit_table, messages
from skewbridge.cli.us_units import UnitsOption, in_units
from skewbridge.cli.variant_options import bridges_of_the_user
from skewbridge.provenance.files import writable_folder


@clear_errors
def check(
    bridge: Annotated[
        str,
        typer.Argument(
            metavar="FILE|NAME",
            help="File of a bridge, or its name.",
            autocompletion=bridges_of_the_user,
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for model.png, else results/bridges and the name."),
    ] = None,
    skew_deg: Annotated[
        float, typer.Option("--skew-deg", help="Skew of the bridge in the picture.")
    ] = 30,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Check the file of a bridge: keys, weight, axial loads, periods, capacities, picture.

    What a study would stumble over is told in words; the exit code is 2 for a file that breaks its
    schema and 0 otherwise.
    """
    from skewbridge.analysis.bridge_check import check_bridge

    found = check_bridge(bridge)
    folder = writable_folder(out or Path("results/bridges") / found.bridge.name)
    picture = _draw(bridge, skew_deg, folder)
    answer = {
        **found.summary(),
        "modes": [asdict(mode) for mode in found.standing.modes],
        "bents": list(found.bents),
        "findings": list(found.findings),
        "picture": str(picture),
    }
    summary = [{"quantity": name, "value": value} for name, value in found.summary().items()]
    emit(answer, summary, as_json=as_json, units=units)
    if not as_json:
        turned = [
            {"of a column": name, **{f"bent {row['bent']}": row[name] for row in found.bents}}
            for name in (found.bents[0] if found.bents else ())
            if name != "bent"
        ]
        emit_table(in_units(turned, units))
    for told in found.findings:
        messages.print(f"warning: {told}", style="yellow")
    messages.print(f"{'no doubts; ' if not found.findings else ''}picture: {picture}")


def _draw(bridge: str, skew_deg: float, folder: Path) -> Path:
    """Write the picture of a bridge with contact at its abutments; return its path."""
    from skewbridge.analysis.step_loop import solver_log
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.model_view import model_figure
    from skewbridge.variant.axes import AXES
    from skewbridge.variant.options import ModelOptions
    from skewbridge.variant.variant import Variant

    values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": skew_deg}
    variant = Variant.at(bridge, "contact_friction", values)
    with solver_log(None):
        geometry = model_geometry(variant, ModelOptions())
    path = folder / "model.png"
    model_figure(geometry).savefig(path, dpi=150)
    return path


COMMANDS: Final = (check,)

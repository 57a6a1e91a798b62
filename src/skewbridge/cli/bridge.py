"""Commands of the bridge package: models, modes, static pushes."""

from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, emit_json, messages
from skewbridge.cli.us_units import Units, UnitsOption, in_units
from skewbridge.cli.variant_options import (
    OutOption,
    SetOption,
    VariantChoice,
    model_options,
    takes_variant,
)
from skewbridge.provenance.files import writable_folder
from skewbridge.units import KN
from skewbridge.variant.abutments import ABUTMENTS

if TYPE_CHECKING:
    from skewbridge.analysis.pushover import PushCurve
    from skewbridge.variant.options import ModelOptions

LADDER_ANGLES_DEG = (0.0, 30.0, 60.0, 90.0, 150.0, 180.0)

DirectionOption = Annotated[
    Literal["x", "y"], typer.Option("--direction", help="x is longitudinal, y transverse.")
]
AngleOption = Annotated[
    float | None,
    typer.Option("--angle-deg", help="Direction counter-clockwise from x; replaces --direction."),
]
MaxDispOption = Annotated[float, typer.Option("--max-disp-m", help="Where the push ends.")]


@clear_errors
@takes_variant()
def modal(
    choice: VariantChoice,
    changes: SetOption = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for modal.parquet.")] = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Weight, dead-load forces, periods and participating masses, gaps open.

    T1 is the conditioning period of the bridge: that of its model with pads at zero skew.
    """
    variant, options = choice.variant(), model_options(changes)
    import pandas as pd

    from skewbridge.analysis.conditioning_period import (
        mean_period_s,
        periods_of_file,
        standing_bridge,
    )
    from skewbridge.analysis.modal import modal_properties
    from skewbridge.analysis.step_loop import solver_log

    slug = variant.normalised().slug
    with solver_log(None):
        result = asdict(modal_properties(variant, options))
    standing = standing_bridge(variant.bridge)
    modes, t1_s = result["modes"], mean_period_s(standing)
    if out is not None:
        pd.DataFrame(modes).to_parquet(writable_folder(out) / "modal.parquet", index=False)
    if not as_json:
        state = {"weight_kn": result["weight_kn"], "axial_kn": list(result["column_axial_kn"])}
        (shown,) = in_units([state], units)
        (weight, axial), unit = shown.values(), "kip" if units == "us" else "kN"
        forces = ", ".join(f"{force:.0f}" for force in axial)
        messages.print(
            f"weight {weight:.0f} {unit}; column base axial force {forces} {unit}; T1 {t1_s:.4g} s"
        )
    for told in periods_of_file(variant.bridge, standing):
        messages.print(f"warning: {told}", style="yellow")
    emit({"variant": slug, "t1_s": t1_s, **result}, modes, as_json=as_json, title=slug)


@clear_errors
@takes_variant(abutment="roller")
def pushover(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.30,
    changes: SetOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Push the whole bridge in proportion to its masses; base shear against displacement."""
    variant, options = choice.variant(), model_options(changes)
    angle = _angle(direction, angle_deg)
    from skewbridge.analysis.pushover import push_bridge
    from skewbridge.analysis.step_loop import solver_log

    with solver_log(None):
        curve = push_bridge(variant, options, angle_deg=angle, max_disp_m=max_disp_m)
    _finish(curve, out, units, as_json=as_json)


@clear_errors
@takes_variant()
def static(
    choice: VariantChoice,
    out: OutOption,
    direction: DirectionOption = "x",
    angle_deg: AngleOption = None,
    max_disp_m: MaxDispOption = 0.20,
    changes: SetOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Push one abutment by its deck end (x: into the backfill, angle 180: away from it).

    `--abutment all` pushes every model of the ladder in six directions and draws them.
    """
    angle = _angle(direction, angle_deg)
    options = model_options(changes)
    if choice.abutment == "all":
        _push_ladder(choice, options, max_disp_m, out, units, as_json=as_json)
        return
    from skewbridge.analysis.pushover import push_abutment
    from skewbridge.analysis.step_loop import solver_log

    variant = choice.variant()
    with solver_log(None):
        curve = push_abutment(variant, options, angle_deg=angle, max_disp_m=max_disp_m, steps=400)
    _finish(curve, out, units, as_json=as_json)


def _push_ladder(
    choice: VariantChoice,
    options: "ModelOptions",
    max_disp_m: float,
    out: Path,
    units: Units,
    *,
    as_json: bool,
) -> None:
    """Push every model of the ladder in all directions; write the curves and their figure."""
    variants = {name: choice.variant(name) for name in ABUTMENTS}
    import pandas as pd

    from skewbridge.analysis.pushover import push_abutment
    from skewbridge.analysis.step_loop import solver_log
    from skewbridge.report.static_figures import ladder_figure

    parts: list[pd.DataFrame] = []
    peaks: list[dict[str, Any]] = []
    for (name, variant), angle in product(variants.items(), LADDER_ANGLES_DEG):
        with solver_log(None):
            curve = push_abutment(
                variant, options, angle_deg=angle, max_disp_m=max_disp_m, steps=400
            )
        place = {"abutment": name, "angle_deg": angle}
        parts.append(pd.DataFrame(place | _columns(curve)))
        peaks.append(place | {"peak_kn": curve.peak_n / KN})
    curves = pd.concat(parts, ignore_index=True)
    folder = writable_folder(out)
    curves.to_parquet(folder / "curve.parquet", index=False)
    first = next(iter(variants.values()))
    title = (
        f"{first.bridge_name}, right abutment, skew {first.skew_deg} degrees, gap {first.gap_mm} mm"
    )
    ladder_figure(curves, title=title).savefig(folder / "ladder.png", dpi=150)
    emit({"pushes": peaks}, peaks, as_json=as_json, title=title, units=units)


def _angle(direction: Literal["x", "y"], angle_deg: float | None) -> float:
    if angle_deg is not None:
        return angle_deg
    return 0.0 if direction == "x" else 90.0


def _columns(curve: "PushCurve") -> dict[str, Any]:
    return {"disp_m": curve.disp_m, "force_kn": curve.force_n / KN}


def _finish(curve: "PushCurve", out: Path, units: Units, *, as_json: bool) -> None:
    """Write the curve and its summary; a push that stopped early ends with an error code."""
    import pandas as pd

    table = pd.DataFrame(_columns(curve))
    table.to_parquet(writable_folder(out) / "curve.parquet", index=False)
    summary = {
        "peak_kn": curve.peak_n / KN,
        "initial_stiffness_kn_per_m": curve.initial_stiffness_n_per_m / KN,
        "disp_at_peak_m": curve.disp_at_peak_m,
        "is_complete": curve.is_complete,
    }
    emit(summary, [summary], as_json=as_json, units=units)
    if not curve.is_complete:
        messages.print(f"the push stopped at {curve.disp_m[-1]:.4f} m: no equilibrium beyond")
        raise typer.Exit(EXIT_FAILED)


@clear_errors
@takes_variant()
def model(
    choice: VariantChoice,
    out: OutOption,
    changes: SetOption = None,
    gap_scale: Annotated[float, typer.Option("--gap-scale", help="Factor on drawn gaps.")] = 20.0,
    as_json: JsonOption = False,
) -> None:
    """Draw a model (model.png, model.html) and write it as a plain OpenSeesPy script."""
    variant, options = choice.variant(), model_options(changes)
    from skewbridge.analysis.model_script import model_script
    from skewbridge.analysis.step_loop import solver_log
    from skewbridge.bridge.geometry import model_geometry
    from skewbridge.report.model_view import model_figure, model_page

    with solver_log(None):
        geometry = model_geometry(variant, options)
    folder = writable_folder(out)
    model_figure(geometry, gap_scale=gap_scale).savefig(folder / "model.png", dpi=150)
    page = model_page(geometry, gap_scale=gap_scale)
    (folder / "model.html").write_text(page, encoding="utf-8")
    with solver_log(None):
        script = model_script(variant, options)
    (folder / "model.py").write_text(script, encoding="utf-8")
    files = [str(folder / name) for name in ("model.png", "model.html", "model.py")]
    if as_json:
        emit_json({"variant": geometry.title, "files": files})
    else:
        messages.print(f"{geometry.title}: {', '.join(files)}")


COMMANDS: Final = (modal, pushover, static, model)

"""Commands about the study as a whole: doctor, plan, status, retry, journal."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, emit_table, messages
from skewbridge.errors import InputError
from skewbridge.statuses import FAILED

if TYPE_CHECKING:
    from skewbridge.study.folder import StudyFolder

DEFAULT_CONFIG: Final = Path("config/config.yaml")
ConfigOption = Annotated[
    Path, typer.Option("--config", help="Configuration, merged over config/config.yaml.")
]

StatusOption = Annotated[
    str,
    typer.Option(
        "--status",
        metavar=f"[failed|{'|'.join(FAILED)}]",
        help="failed: all without a result.",
        autocompletion=lambda: ["failed", *FAILED],
    ),
]
CompactOption = Annotated[
    bool, typer.Option("--compact", help="Drop lines that are repeated, outdated or damaged.")
]


@clear_errors
def doctor(*, as_json: JsonOption = False) -> None:
    """Check the environment: versions, OpenSees, a one-second self-test."""
    import platform
    from importlib.metadata import version

    packages = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "joblib", "snakemake")
    report: dict[str, Any] = {
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }
    began_s = time.perf_counter()
    try:
        from skewbridge.verification.studies.gate import verify_contact_gate

        began_s = time.perf_counter()
        checks = verify_contact_gate()
        failed = [str(name) for name in checks.loc[~checks["pass"], "quantity"]]
        report["self_test"] = f"failed: {', '.join(failed)}" if failed else "passed"
    except ImportError as error:
        failed = ["import"]
        report["self_test"] = f"OpenSees does not import ({error}): run make setup again"
    report["self_test_s"] = round(time.perf_counter() - began_s, 2)
    emit(report | {"ok": not failed}, as_json=as_json)
    if failed:
        raise typer.Exit(EXIT_FAILED)


@clear_errors
def plan(
    *,
    config: ConfigOption = DEFAULT_CONFIG,
    pilot: Annotated[
        int | None,
        typer.Option(
            metavar="MOTIONS",
            help="Analyse so many motions on corner variants and propose where levels should lie.",
        ),
    ] = None,
    profile: Annotated[
        str | None,
        typer.Option(
            "--profile",
            metavar="slurm|FOLDER",
            help="Of a cluster: jobs and hours there besides.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show the variants and analyses of a study, their cost, and what is done already.

    Of a finished study also with how many motions each headline answer is decided.
    """
    from skewbridge.study.config import load_config
    from skewbridge.study.inputs import check_inputs

    study = load_config(config, base=DEFAULT_CONFIG)
    check_inputs(study)
    _warn_of_periods(study.bridges_with_periods())
    if pilot is not None:
        _propose_levels(config, pilot, as_json=as_json)
        return
    forecast, variants = _forecast(config, profile)
    needed = _needed_motions(config)
    if not as_json:
        emit_table([{"variant": slug, "analyses": count} for slug, count in variants.items()])
    emit(forecast | {"needed_motions": needed}, _study_rows(forecast), as_json=as_json)
    if needed and not as_json:
        emit_table([_needed_row(row) for row in needed], "Motions that decide the pooled effects")


@clear_errors
def status(
    *,
    failed: Annotated[
        bool, typer.Option("--failed", help="List the analyses without a usable result.")
    ] = False,
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Show what is done, failed and left, with the convergence ledger.

    With --failed each analysis without a usable result, and the command that repeats it alone.
    """
    if failed:
        from skewbridge.study.config import load_config
        from skewbridge.study.forecast import failed_analyses

        found = failed_analyses(load_config(config, base=DEFAULT_CONFIG))
        shown = [{name: row[name] for name in ("variant", "motion", "status")} for row in found]
        emit({"failed": len(found), "analyses": found}, shown, as_json=as_json)
        for row in found:
            messages.print(f"{row['command']}   # {row['reason']}", markup=False)
        return
    forecast, _ = _forecast(config)
    emit(forecast, _study_rows(forecast), as_json=as_json)


@clear_errors
def retry(
    *,
    status: StatusOption = "failed",
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Forget failed analyses, so that the study tries them again when it is run."""
    from skewbridge.study.upkeep import forget

    if status != "failed" and status not in FAILED:
        raise InputError(f"status: must be failed or one of {', '.join(FAILED)}, got {status}")
    rows = forget(_folder(config), FAILED if status == "failed" else (status,))
    found = [
        {"variant": row["variant"], "motion": row["motion_id"], "status": row["status"]}
        for row in rows
    ]
    emit({"forgotten": len(found), "analyses": found}, found, as_json=as_json)
    messages.print(f"{len(found)} to be tried again: run the study", markup=False)


@clear_errors
def journal(
    *,
    compact: CompactOption = False,
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Count the lines of the journals, and drop those that do not count."""
    from skewbridge.study.journal import read_content
    from skewbridge.study.upkeep import compact_journals

    folder = _folder(config)
    content = compact_journals(folder) if compact else read_content(folder.journals)
    counts = {
        "analyses": len(content.rows),
        "repeated": content.repeated,
        "outdated": content.outdated,
        "damaged": content.damaged,
    }
    rows = [{"lines": name, "count": count} for name, count in counts.items()]
    emit(counts | {"compacted": compact}, rows, as_json=as_json)


def _folder(config: Path) -> "StudyFolder":
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder

    return StudyFolder(Path(load_config(config, base=DEFAULT_CONFIG).results))


def _propose_levels(config: Path, motions: int, *, as_json: bool) -> None:
    """Run the pilot of a study and show the levels that it proposes."""
    from dataclasses import asdict

    from skewbridge.study.config import load_config
    from skewbridge.study.pilot import run_pilot

    found, rows = run_pilot(load_config(config, base=DEFAULT_CONFIG), motions)
    variants = len({row["variant"] for row in rows})
    title = f"{len(rows)} analyses of {variants} variants; share = with outcomes on both sides"
    answer = asdict(found) | {"analyses": len(rows), "variants": variants}
    emit(answer, found.states, as_json=as_json, title=title)
    if as_json:
        return
    told = (found.configured_g, found.configured_share), (found.level_range_g, found.share)
    for (low_g, high_g), share in told:
        messages.print(
            f"levels {low_g:g} to {high_g:g} g: two motions or more on both sides of {share:.1%} "
            f"of the {found.in_reach} states in reach (of {found.n_states})",
            markup=False,
        )
    same = found.level_range_g == found.configured_g
    words = "the configuration can stay:" if same else "to paste into the configuration:"
    messages.print(f"{words}\n{found.config_lines}", markup=False)


def _warn_of_periods(bridges: tuple[str, ...]) -> None:
    from skewbridge.analysis.conditioning_period import periods_of_file, standing_bridge

    for name in bridges:
        for told in periods_of_file(name, standing_bridge(name)):
            messages.print(f"warning: {told}", style="yellow")


def _study_rows(forecast: dict[str, Any]) -> list[dict[str, Any]]:
    ledger = forecast["ledger"]
    rows = {name: value for name, value in forecast.items() if name != "ledger"}
    rows |= {f"status {name}": count for name, count in ledger["status"].items()}
    rows |= {f"recovery rung {rung}": count for rung, count in ledger["rung"].items()}
    return [{"study": name, "value": value} for name, value in rows.items()]


def _needed_motions(config: Path) -> list[dict[str, Any]]:
    """Return what the finished study of a configuration says; nothing where there is none."""
    from skewbridge.provenance.tables import read_frame
    from skewbridge.reading import records_of
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder

    folder = StudyFolder(Path(load_config(config, base=DEFAULT_CONFIG).results))
    path = folder.fragility("needed_motions")
    if not path.is_file():
        return []
    return records_of(read_frame(path))


def _needed_row(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table on a screen."""
    return {
        "bridge": f"{row['bridge']} {row['abutment']}".replace("_", "-"),
        "demand": row["demand"],
        "change": f"{row['axis']} {row['from_value']:g} to {row['to_value']:g}",
        "verdict": row["verdict"],
        "motions": row["n_motions"],
        "forecast": row["forecast"],
        **{
            name.replace("_", " "): None if row[name] != row[name] else row[name]
            for name in ("needed_motions", "more_analyses", "more_core_hours")
        },
    }


def _forecast(config: Path, profile: str | None = None) -> tuple[dict[str, Any], dict[str, int]]:
    from skewbridge.study.cluster import JobSize
    from skewbridge.study.config import load_config
    from skewbridge.study.forecast import forecast_study

    size = None if profile is None else JobSize.of_profile(profile)
    forecast = forecast_study(load_config(config, base=DEFAULT_CONFIG), size)
    for note in forecast.notes:
        messages.print(note)
    return forecast.summary, forecast.analyses_by_variant


COMMANDS: Final = (doctor, plan, status, retry, journal)

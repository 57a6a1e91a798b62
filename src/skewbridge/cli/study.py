"""Commands about the study as a whole: doctor, plan, status."""

import time
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, emit_table, messages

DEFAULT_CONFIG: Final = Path("config/config.yaml")
ConfigOption = Annotated[
    Path, typer.Option("--config", help="Configuration, merged over config/config.yaml.")
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
    profile: Annotated[
        str | None,
        typer.Option(
            "--profile", help="Of a cluster, slurm or a folder: jobs and hours there besides."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show the variants and analyses of a study, their cost, and what is done already."""
    forecast, variants = _forecast(config, profile)
    if not as_json:
        emit_table([{"variant": slug, "analyses": count} for slug, count in variants.items()])
    emit(forecast, _study_rows(forecast), as_json=as_json)


@clear_errors
def status(*, config: ConfigOption = DEFAULT_CONFIG, as_json: JsonOption = False) -> None:
    """Show what is done, failed and left, with the convergence ledger."""
    forecast, _ = _forecast(config)
    emit(forecast, _study_rows(forecast), as_json=as_json)


def _study_rows(forecast: dict[str, Any]) -> list[dict[str, Any]]:
    ledger = forecast["ledger"]
    rows = {name: value for name, value in forecast.items() if name != "ledger"}
    rows |= {f"status {name}": count for name, count in ledger["status"].items()}
    rows |= {f"recovery rung {rung}": count for rung, count in ledger["rung"].items()}
    return [{"study": name, "value": value} for name, value in rows.items()]


def _forecast(config: Path, profile: str | None = None) -> tuple[dict[str, Any], dict[str, int]]:
    from skewbridge.study.cluster import JobSize
    from skewbridge.study.config import load_config
    from skewbridge.study.forecast import forecast_study

    size = None if profile is None else JobSize.of_profile(profile)
    forecast = forecast_study(load_config(config, base=DEFAULT_CONFIG), size)
    for note in forecast.notes:
        messages.print(note, markup=False)
    return forecast.summary, forecast.analyses_by_variant


COMMANDS: Final = (doctor, plan, status)

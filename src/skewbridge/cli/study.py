"""Commands about the study as a whole: doctor, plan, status, provenance."""

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
def plan(*, config: ConfigOption = DEFAULT_CONFIG, as_json: JsonOption = False) -> None:
    """Show the variants and analyses of a study, their cost, and what is done already."""
    forecast, variants = _forecast(config)
    if not as_json:
        emit_table([{"variant": slug, "analyses": count} for slug, count in variants.items()])
    emit(forecast, _study_rows(forecast), as_json=as_json)


@clear_errors
def status(*, config: ConfigOption = DEFAULT_CONFIG, as_json: JsonOption = False) -> None:
    """Show what is done, failed and left, with the convergence ledger."""
    forecast, _ = _forecast(config)
    emit(forecast, _study_rows(forecast), as_json=as_json)


@clear_errors
def provenance(
    file: Annotated[Path, typer.Argument(help="Table, figure, page or JSON of a study or run.")],
    *,
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Show where a result comes from; exit 1 if the present sources and config give another."""
    from skewbridge.study.origin import origin_of

    origin = origin_of(file, config)
    rows = [
        {"provenance": name, "of the file": value, "now": _now(origin.now.get(name), value)}
        for name, value in sorted(origin.told.items())
    ]
    answer = {"current": origin.is_current, "provenance": origin.told, "now": origin.now}
    emit(answer | {"differences": origin.differences}, rows, as_json=as_json)
    if not origin.is_current:
        messages.print("not current: the present sources or configuration give another result")
        raise typer.Exit(EXIT_FAILED)
    if origin.differences:
        messages.print(f"current: what differs ({', '.join(origin.differences)}) is not used by it")
    else:
        messages.print("current: the present sources and configuration give this result")


def _now(value: str | None, of_file: str) -> str:
    return "" if value is None else "same" if value == of_file else value


def _study_rows(forecast: dict[str, Any]) -> list[dict[str, Any]]:
    ledger = forecast["ledger"]
    rows = {name: value for name, value in forecast.items() if name != "ledger"}
    rows |= {f"status {name}": count for name, count in ledger["status"].items()}
    rows |= {f"recovery rung {rung}": count for rung, count in ledger["rung"].items()}
    return [{"study": name, "value": value} for name, value in rows.items()]


def _forecast(config: Path) -> tuple[dict[str, Any], dict[str, int]]:
    from skewbridge.study.config import load_config
    from skewbridge.study.forecast import forecast_study

    forecast = forecast_study(load_config(config, base=DEFAULT_CONFIG))
    for note in forecast.notes:
        messages.print(note, markup=False)
    return forecast.summary, forecast.analyses_by_variant


COMMANDS: Final = (doctor, plan, status, provenance)

"""Check the products of the study."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.demands.suspect import SuspectLimits
        from skewbridge.reading import checked
        from skewbridge.report.checks import read_tables, write_checks

        tables = {name: Path(path) for name, path in snakemake.input.items()}
        write_checks(
            read_tables(**tables, **snakemake.params.asked),
            Path(snakemake.output.checks),
            strict=snakemake.params.strict,
            suspect=checked(SuspectLimits, snakemake.params.suspect, "suspect"),
        )

"""Check the products of the study."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.report.checks import write_checks

        write_checks(
            demands=Path(snakemake.input.demands),
            curves=Path(snakemake.input.curves),
            effects=Path(snakemake.input.effects),
            output=Path(snakemake.output.checks),
        )

"""Draw the figures of the report."""

from pathlib import Path

from skewbridge.cli.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.report.study_figures import draw_study

        draw_study(
            demands=Path(snakemake.input.demands),
            curves=Path(snakemake.input.curves),
            effects=Path(snakemake.input.effects),
            suite=Path(snakemake.input.suite),
            friction_pair=Path(snakemake.input.friction_pair),
            folder=Path(snakemake.output.folder),
        )

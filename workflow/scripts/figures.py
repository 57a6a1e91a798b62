"""Draw the figures of the report."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.report.study_figures import draw_study

        draw_study(
            {name: Path(path) for name, path in snakemake.input.items()},
            folder=Path(snakemake.output.folder),
            captions=Path(snakemake.output.captions),
        )

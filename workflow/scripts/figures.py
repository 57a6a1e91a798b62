"""Draw the figures of the report."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.reading import checked
        from skewbridge.report.study_figures import draw_study
        from skewbridge.study.figure_settings import FigureSettings

        made = snakemake.params.choices
        draw_study(
            {name: Path(path) for name, path in snakemake.input.items()},
            choices=Path(made["table"]) if made else None,
            folder=Path(snakemake.output.folder),
            captions=Path(snakemake.output.captions),
            settings=checked(FigureSettings, snakemake.params.look, "figures"),
            n_jobs=snakemake.threads,
        )

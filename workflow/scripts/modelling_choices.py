"""Compare other choices of the modeller with the configured model on a few motions."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.guard import Workers
        from skewbridge.study.modelling_choices import write_choices
        from skewbridge.study.setup import StudySetup

        choices = snakemake.params.choices
        folder = StudyFolder(Path(snakemake.params.results))
        write_choices(
            StudySetup.from_sections(choices["sections"], folder),
            choices["variants"],
            choices["axes"],
            motions=choices["motions"],
            workers=Workers(
                count=snakemake.threads, no_progress_s=snakemake.resources.no_progress_s
            ),
            output=Path(snakemake.output.table),
            digest=snakemake.params.made_for,
        )

"""Repeat a few analyses at the reference accuracy and with other penalties."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.guard import Workers
        from skewbridge.study.sensitivity import write_sensitivity
        from skewbridge.study.setup import StudySetup

        folder = StudyFolder(Path(snakemake.params.results))
        setup = StudySetup.from_sections(snakemake.params.sections, folder)
        write_sensitivity(
            setup,
            snakemake.params.variants,
            count=snakemake.params.rows,
            window_s=snakemake.params.window_s,
            workers=Workers(
                count=snakemake.threads, no_progress_s=snakemake.resources.no_progress_s
            ),
            output=Path(snakemake.output.table),
        )

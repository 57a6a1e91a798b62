"""List the analyses of the study, so that every variant knows how far the whole is."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake.log[0]):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.runs import write_plan
        from skewbridge.study.setup import StudySetup

        folder = StudyFolder(Path(snakemake.params.results))
        setup = StudySetup.from_sections(snakemake.params.sections, folder)
        write_plan(setup, snakemake.params.variants, Path(snakemake.output.plan))

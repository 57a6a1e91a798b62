"""List the analyses of the study with their forecast."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.analysis.modal import warn_of_periods
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.plan import write_plan
        from skewbridge.study.setup import StudySetup

        sections = snakemake.params.sections
        folder = StudyFolder(Path(snakemake.params.results))
        setup = StudySetup.from_sections(sections, folder)
        write_plan(setup, snakemake.params.variants, sections)
        warn_of_periods(bridge for bridge, _ in setup.measures)

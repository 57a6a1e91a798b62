"""Repeat one analysis without and with friction, with its histories."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.friction_pair import write_friction_pair
        from skewbridge.study.setup import StudySetup

        folder = StudyFolder(Path(snakemake.params.results))
        setup = StudySetup.from_sections(snakemake.params.sections, folder)
        write_friction_pair(setup, Path(snakemake.input.demands), Path(snakemake.output.histories))

"""Join the demands of all parts into one checked table, and one of every variant."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.demands.suspect import SuspectLimits
        from skewbridge.reading import checked
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.runs import collect_parts

        folder = StudyFolder(Path(snakemake.input.plan).parent)
        limits = checked(SuspectLimits, snakemake.params.suspect, "suspect")
        collect_parts(folder, map(Path, snakemake.input.parts), limits)

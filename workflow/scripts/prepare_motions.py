"""Read the motions, choose their factors and measure their intensity."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake):
        from skewbridge.motions.levels import MotionsConfig
        from skewbridge.reading import checked
        from skewbridge.study.folder import StudyFolder
        from skewbridge.study.prepare import prepare_motions

        prepare_motions(
            checked(MotionsConfig, snakemake.params.motions, "motions"),
            conditioning_t1_s=snakemake.params.conditioning_t1_s,
            t1_s=snakemake.params.t1_s,
            folder=StudyFolder(Path(snakemake.params.results)),
        )

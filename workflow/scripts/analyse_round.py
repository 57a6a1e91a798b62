"""Analyse one variant under the motions of one round; the journal has each finished analysis."""

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.analyses import StudySetup, analyse_variant
        from skewbridge.study.rounds import setup_of_round

        variant = snakemake.wildcards.variant
        analyse_variant(
            setup_of_round(StudySetup.of(job.study), job.inputs["plan"], variant),
            variant,
            workers=job.workers,
            limits=job.study.suspect,
            output=job.outputs["demands"],
        )

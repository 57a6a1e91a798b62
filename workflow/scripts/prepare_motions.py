"""Read the motions, choose their scale factors and compute their intensities."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.analysis.modal import warn_of_periods
        from skewbridge.study.inputs import prepare_motions

        prepare_motions(job.study, job.threads)
        warn_of_periods(job.study.grid.bridge)

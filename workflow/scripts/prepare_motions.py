"""Read the motions, choose their factors and measure their intensity."""

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.analysis.modal import warn_of_periods
        from skewbridge.bridge.catalogue import load_bridge
        from skewbridge.study.config import CONDITIONING_BRIDGE
        from skewbridge.study.inputs import prepare_motions

        prepare_motions(
            job.study.motions,
            conditioning_t1_s=load_bridge(CONDITIONING_BRIDGE).t1_s,
            t1_s={name: load_bridge(name).t1_s for name in job.study.grid.bridge},
            folder=job.folder,
        )
        warn_of_periods(job.study.grid.bridge)

"""Join the demands of all variants into one table."""

from pathlib import Path

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.demands.tables import join_variants

        join_variants(list(map(Path, snakemake.input)), job.outputs["demands"])

"""Choose the analyses of a round from the demands of the earlier ones."""

from pathlib import Path

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.rounds import plan_round

        plan_round(
            job.study,
            int(snakemake.wildcards.round),
            list(map(Path, snakemake.input.earlier)),
            job.outputs["plan"],
        )

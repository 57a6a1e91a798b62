"""Join what every round decided into one table."""

from pathlib import Path

from skewbridge.study.session import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.rounds import write_rounds

        write_rounds(list(map(Path, snakemake.input.plans)), job.outputs["rounds"])

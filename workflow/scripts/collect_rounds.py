"""Join the verdicts of all rounds into one table."""

from pathlib import Path

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.files.text import read_json
        from skewbridge.fragility.study_tables import write_described
        from skewbridge.fragility.verdicts import ROUND_COLUMNS, rounds_table

        plans = [read_json(Path(path)) for path in snakemake.input]
        write_described(rounds_table(plans), job.outputs["rounds"], ROUND_COLUMNS)

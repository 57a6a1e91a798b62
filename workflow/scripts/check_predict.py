"""Compare predicted medians with new analyses of variants inside the grid."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.predict_check import write_predict_check

        write_predict_check(
            job.setup,
            job.study.grid.values(),
            job.inputs,
            job.study.fragility,
            job.outputs["table"],
        )

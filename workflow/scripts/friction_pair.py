"""Run one analysis without and with friction and store its histories."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.repeats import write_friction_pair

        write_friction_pair(job.setup, job.inputs["demands"], job.outputs["histories"])

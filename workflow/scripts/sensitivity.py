"""Repeat a few analyses at the reference accuracy and with other penalties."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.repeats import write_sensitivity
        from skewbridge.variant.grid import expand_grid

        variants = expand_grid(job.study.grid)
        most_friction = max(variant.friction_pct for variant in variants)
        slugs = [each.slug for each in variants if each.friction_pct == most_friction]
        write_sensitivity(job.setup, slugs, job.outputs["table"])

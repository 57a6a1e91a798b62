"""Repeat a few analyses at the reference accuracy and with other penalties."""

import os
from dataclasses import replace

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.study.repeats import write_sensitivity
        from skewbridge.variant.grid import expand_grid

        variants = expand_grid(job.study.grid)
        most_friction = max(variant.friction_pct for variant in variants)
        slugs = [each.slug for each in variants if each.friction_pct == most_friction]
        os.nice(10)  # the last analyses of the variants come first
        workers = max(job.threads, job.processors)
        write_sensitivity(replace(job.setup, workers=workers), slugs, job.outputs["table"])

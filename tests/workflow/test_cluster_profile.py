"""The workflow with the profile of a cluster, planned where there is none."""

import os
import re
import subprocess
import sys
from pathlib import Path

from small_study import copy_sources

SNAKEMAKE = Path(sys.executable).parent / "snakemake"


def test_the_profile_plans_a_job_for_each_variant(tmp_path: Path) -> None:
    """With the processors, time and partition that the environment names."""
    tree = tmp_path / "tree"
    copy_sources(tree)
    site = {"SKEWBRIDGE_JOB_CORES": "2", "SKEWBRIDGE_JOB_MINUTES": "17", "SBATCH_PARTITION": "long"}
    planned = subprocess.run(
        [str(SNAKEMAKE), "-n", "--workflow-profile", "workflow/profiles/slurm"],
        cwd=tree,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | site,
    )
    text = planned.stdout + planned.stderr
    assert planned.returncode == 0, text
    assert re.search(r"^analyse +24$", text, re.MULTILINE)
    jobs = re.findall(r"rule analyse:.*?resources: (.*?)$", text, re.DOTALL | re.MULTILINE)
    assert len(jobs) == 24
    asked = {"mem_mb=1600", "runtime=17", "slurm_partition=long"}
    assert all(asked <= set(job.split(", ")) for job in jobs)

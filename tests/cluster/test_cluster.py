"""The small study through a real Slurm of two nodes on this host, with jobs and nodes that fail.

It needs root, the packages slurm-wlm and munge, and a host that belongs to no cluster."""

import json
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pandas as pd
import psutil
import pytest

from small_study import SNAKEMAKE, TIMES, copy_sources, done, journal_keys

pytestmark = pytest.mark.cluster

HERE = Path(__file__).parent
TABLES = ["demands", "fragility/curves", "fragility/effects", "fragility/median_effects"]
STUDY = """
grid: {bridge: [osb1], skew_deg: [30], gap_mm: [25]}
motions: {count: 4, incidence_deg: [0.0], blocks: null, bands: null}
analysis: {duration_s: 6.0}
sensitivity: {rows: 0}
"""
SITE = {"SKEWBRIDGE_JOB_CORES": "1", "SKEWBRIDGE_POLL_S": "3", "SKEWBRIDGE_JOBS": "4"}


def missing():
    """Why there can be no Slurm here; empty if there can."""
    if os.getuid() != 0:
        return "only root may start Slurm's daemons"
    for name in ("munged", "slurmctld", "slurmd"):
        if shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin") is None:
            return f"{name} is not installed (apt-get install slurm-wlm munge)"
    if Path("/etc/slurm/slurm.conf").exists():
        return "this host belongs to a cluster (/etc/slurm/slurm.conf)"
    return ""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """The folder of a running Slurm with the nodes node1 and node2."""
    if reason := missing():
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("slurm")
    for parent in [folder, *folder.parents[:2]]:  # munged refuses a socket that others cannot reach
        parent.chmod(0o755)
    try:
        subprocess.run([HERE / "start.sh", folder], check=True)
        yield folder
    finally:
        subprocess.run([HERE / "stop.sh", folder], check=True)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    tree = copy_sources(tmp_path_factory.mktemp("cluster") / "tree")
    (tree / "study.yaml").write_text(STUDY)
    (tree / "local.yaml").write_text(f"{STUDY}results: local\n")
    return tree


def through_slurm(*arguments):
    """The command of `make study PROFILE=slurm`, with what it does not fix."""
    profile = ["--workflow-profile", "workflow/profiles/slurm"]
    return [str(SNAKEMAKE), *profile, "--configfile", "study.yaml", *arguments]


def jobs_of(rule):
    listed = done(["squeue", "--noheader", "--states=running", "--format=%i %N %k"], HERE)
    words = [line.split(maxsplit=2) for line in listed.stdout.splitlines()]
    return {job: node for job, node, comment in words if comment.startswith(f"rule_{rule}")}


def lose(cluster, node, job):
    """Kill what of Slurm is on a node but nothing of its job, the worst that may happen."""
    os.kill(int((cluster / f"slurmd.{node}.pid").read_text()), signal.SIGKILL)
    for process in psutil.process_iter(["cmdline"]):
        if " ".join(process.info["cmdline"] or []).startswith(f"slurmstepd: [{job}."):
            process.kill()


@pytest.fixture(scope="module")
def study(cluster, tree):
    """The finished study, of which a job was cancelled and a node was lost for a time. After the
    first analyses one of the two jobs of analyses is cancelled. On the node of the other one Slurm
    is killed, and started again when the controller has missed it. Meanwhile the processes of that
    job go on, and the controller puts the job into the queue again."""
    log = tree / "slurm.log"
    with log.open("w") as output:
        given = {"cwd": tree, "stdout": output, "stderr": output, "env": os.environ | SITE}
        process = subprocess.Popen(through_slurm(), **given)

        def wait_for(condition, seconds):
            deadline = time.monotonic() + seconds
            while not condition():
                if process.poll() is not None or time.monotonic() > deadline:
                    pytest.fail(log.read_text())
                time.sleep(0.2)

        try:
            wait_for(lambda: journal_keys(tree) and len(jobs_of("analyse")) > 1, 900)
            (cancelled, _), (lost, node) = jobs_of("analyse").items()
            lose(cluster, node, lost)
            subprocess.run(["scancel", cancelled], check=True)
            (tree / "finished.json").write_text(json.dumps(journal_keys(tree)))
            state = ["sinfo", "--noheader", "--nodes", node, "--format=%T"]
            wait_for(lambda: "down" in done(state, HERE).stdout, 120)
            subprocess.run(["slurmd", "-N", node], check=True)
            assert process.wait(1200) == 0, log.read_text()
        finally:
            process.kill()
    return tree


def test_a_cancelled_job_and_a_lost_node_lose_and_repeat_nothing_and_change_no_table(study):
    finished = json.loads((study / "finished.json").read_text())
    keys = journal_keys(study)
    assert finished
    assert len(keys) == len(set(keys)) == 8
    assert set(finished) <= set(keys)
    assert "Trying to restart job" in (study / "slurm.log").read_text()
    assert (study / "results/report.html").is_file()
    again = done(through_slurm("-n"), study, environment=SITE)
    assert "Nothing to be done" in again.stdout + again.stderr
    targets = [f"local/{name}.parquet" for name in TABLES]
    done([SNAKEMAKE, "-j2", "--configfile", "local.yaml", "--", *targets], study)
    for name in TABLES:
        here = pd.read_parquet(study / f"local/{name}.parquet")
        there = pd.read_parquet(study / f"results/{name}.parquet")
        left_out = [column for column in TIMES if column in here]
        pair = (table.drop(columns=left_out) for table in (there, here))
        pd.testing.assert_frame_equal(*pair, check_exact=True)


def test_a_job_over_its_memory_is_tried_again_with_more(cluster, tree):
    """This host can enforce it: the memory of a job is sampled and the job is ended."""
    gate = "memory/verification/contact_checks.parquet"
    more = ["--config", "results=memory", "--set-resources"]
    more += ["verify_contact:mem_mb=60 if attempt == 1 else 1500", "--", gate]
    messages = done(through_slurm(*more), tree, environment=SITE).stderr
    assert (tree / gate).is_file()
    assert messages.count("Trying to restart job") == 1
    logs = tree.glob(".snakemake/slurm_logs/*verify_contact*/*.log")
    assert any("exceeded memory limit" in path.read_text() for path in logs)

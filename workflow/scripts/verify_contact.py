"""Check the contact law and its OpenSees unit; stop the study if a check fails."""

import logging

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.files.digests import provenance
        from skewbridge.files.tables import write_frame
        from skewbridge.verification.registry import run_study

        checks = run_study("gate").table()
        failed = checks[~checks["pass"]]
        if len(failed):
            logging.getLogger("skewbridge").error("checks of the contact law failed:\n%s", failed)
            raise SystemExit(1)
        write_frame(checks, job.outputs["table"], provenance())

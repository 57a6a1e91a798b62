"""Run the studies of the paper, compare them with references and judge its statements."""

import logging

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.verification.registry import run_studies

        logger = logging.getLogger("skewbridge")
        rows = run_studies([], job.outputs["table"].parent, report_progress=logger.info)
        failed = [f"{row['study']}: {row['quantity']}" for row in rows if not row["pass"]]
        if failed:
            logger.error("%d of %d checks failed:\n%s", len(failed), len(rows), "\n".join(failed))
            raise SystemExit(1)

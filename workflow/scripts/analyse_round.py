"""Analyse one variant under the motions of one round; store each analysis in the journal."""

from skewbridge.study.jobs import script_session

if __name__ == "__main__":
    with script_session(snakemake) as job:
        from skewbridge.files.text import read_json
        from skewbridge.study.analyses import analyse_variant

        variant = snakemake.wildcards.variant
        first, end = read_json(job.inputs["plan"])["motions"][variant]
        analyse_variant(job.setup.of_motions(first, end), variant, job.outputs["demands"])

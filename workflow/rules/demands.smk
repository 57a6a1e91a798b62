# One job per variant. Its journal keeps finished analyses, so a job that runs again repeats none.
# The contact checks are an input so that they run first.
rule analyse:
    """Analyse one bridge variant under all motions."""
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        contact_checks=rules.verify_contact.output.table,
    output:
        demands=FOLDER.variant_demands("{variant}"),
    log:
        FOLDER.log("analyse/{variant}"),
    benchmark:
        FOLDER.benchmark("analyse_{variant}")
    priority: 50
    threads: ANALYSIS_THREADS
    resources:
        mem_mb=lambda wildcards, threads, attempt: (900 + 350 * threads) * attempt,
        runtime=by_attempt(240),
    params:
        results=results_folder,
        made_from=MADE_FROM["analyse"],
    script:
        "../scripts/analyse.py"


rule collect_demands:
    """Join the demands of all variants into one table."""
    input:
        demands_of_rounds
        if STUDY.design.until
        else [FOLDER.variant_demands(variant) for variant in VARIANTS],
    output:
        demands=FOLDER.demands,
    log:
        FOLDER.log("collect_demands"),
    benchmark:
        FOLDER.benchmark("collect_demands")
    resources:
        mem_mb=by_attempt(4000),
        runtime=by_attempt(60),
    params:
        results=results_folder,
        made_from=MADE_FROM["collect_demands"],
    script:
        "../scripts/collect_demands.py"


# It starts when a processor has no more variants to analyse, and then uses all processors, so that
# none is idle during the last analyses.
rule sensitivity:
    """Repeat some analyses at the reference accuracy and with other penalties."""
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        contact_checks=rules.verify_contact.output.table,
    output:
        table=FOLDER.sensitivity,
    log:
        FOLDER.log("sensitivity"),
    benchmark:
        FOLDER.benchmark("sensitivity")
    priority: 40
    threads: 1
    resources:
        mem_mb=lambda wildcards, threads, attempt: (900 + 350 * threads) * attempt,
        runtime=by_attempt(120),
    params:
        results=results_folder,
        made_from=MADE_FROM["sensitivity"],
    script:
        "../scripts/sensitivity.py"


rule modelling_choices:
    """Change options of the model one at a time, under a few motions (make choices)."""
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        contact_checks=rules.verify_contact.output.table,
    output:
        table=FOLDER.modelling_choices,
    log:
        FOLDER.log("modelling_choices"),
    benchmark:
        FOLDER.benchmark("modelling_choices")
    threads: 64  # Snakemake reduces this to the cores that it may use
    resources:
        mem_mb=lambda wildcards, threads, attempt: (900 + 350 * threads) * attempt,
        runtime=by_attempt(240),
    params:
        results=results_folder,
        made_from=MADE_FROM["modelling_choices"],
    script:
        "../scripts/modelling_choices.py"

rule fit_fragility:
    """Fit all curves, effects, joint models and systems, and check the tables of the study."""
    input:
        **ROUNDS,
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        limit_states=ancient(STUDY.fragility.limit_states),  # its content is in params
    output:
        curves=FOLDER.fragility("curves"),
        medians=FOLDER.fragility("median_effects"),
        effects=FOLDER.fragility("effects"),
        intensity_effects=FOLDER.fragility("intensity_effects"),
        needed_motions=FOLDER.fragility("needed_motions"),
        input_notes=FOLDER.fragility("input_notes"),
        system=FOLDER.fragility("system"),
        measures=FOLDER.fragility("measures"),
        joint=FOLDER.fragility("joint"),
        suites=FOLDER.fragility("suites"),
        suite_curves=FOLDER.fragility("suite_curves"),
        shear_models=FOLDER.fragility("shear_models"),
        rates=FOLDER.fragility("rates"),
        rate_effects=FOLDER.fragility("rate_effects"),
        tex=FOLDER.fragility("table", "tex"),
        csv=report(
            FOLDER.fragility("table", "csv"),
            caption="../report/table.rst",
            category="Tables",
        ),
        checks=report(FOLDER.checks, caption="../report/checks.rst", category="Checks"),
    log:
        FOLDER.log("fit_fragility"),
    benchmark:
        FOLDER.benchmark("fit_fragility")
    threads: 2
    resources:
        mem_mb=by_attempt(3000),
        runtime=by_attempt(120),
    params:
        results=results_folder,
        made_from=MADE_FROM["fit_fragility"],
    script:
        "../scripts/fit_fragility.py"


# Not needed for the report, which includes this table if it exists and is current.
rule check_predict:
    """Compare predicted medians with new analyses of variants inside the grid."""
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        demands=rules.collect_demands.output.demands,
        joint=rules.fit_fragility.output.joint,
        limit_states=ancient(STUDY.fragility.limit_states),  # its content is in params
    output:
        table=FOLDER.fragility("check_predict"),
    log:
        FOLDER.log("check_predict"),
    benchmark:
        FOLDER.benchmark("check_predict")
    threads: 64  # Snakemake reduces this to the cores that it may use
    resources:
        mem_mb=lambda wildcards, threads, attempt: (900 + 350 * threads) * attempt,
        runtime=by_attempt(240),
    params:
        results=results_folder,
        made_from=MADE_FROM["check_predict"],
    script:
        "../scripts/check_predict.py"

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
        joint=FOLDER.fragility("joint"),
        suites=FOLDER.fragility("suites"),
        shear_models=FOLDER.fragility("shear_models"),
        alternatives=FOLDER.fragility("alternatives"),
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

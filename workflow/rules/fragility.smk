rule fit_fragility:
    input:
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        limit_states=ancient(STUDY.fragility.limit_states),
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
        paper=[FOLDER.fragility("table", ending) for ending in ("csv", "tex")],
    log:
        FOLDER.log("fit_fragility"),
    threads: workflow.cores
    params:
        fragility=section("fragility"),
        limit_states=LIMIT_STATES,
        digest=script_digest(
            "fit_fragility", rules.prepare_motions, rules.collect_demands
        ),
    script:
        "../scripts/fit_fragility.py"


# Error of `skewbridge predict` inside the grid, from new analyses: `make check-predict`. It is on no
# path to the report, which quotes the table where there is one.
rule check_predict:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        demands=rules.collect_demands.output.demands,
        joint=rules.fit_fragility.output.joint,
        limit_states=ancient(STUDY.fragility.limit_states),
    output:
        table=FOLDER.fragility("check_predict"),
    log:
        FOLDER.log("check_predict"),
    threads: workflow.cores
    resources:
        no_progress_s=STUDY.batches.no_progress_s,
    params:
        results=results_folder,
        axes=STUDY.grid.values(),
        sections=ANALYSIS_SECTIONS,
        bridges=BRIDGES,
        opensees=opensees_version(),
        fragility=section("fragility"),
        digest=script_digest(
            "check_predict",
            rules.prepare_motions,
            rules.collect_demands,
            rules.fit_fragility,
        ),
    script:
        "../scripts/check_predict.py"

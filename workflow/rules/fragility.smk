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

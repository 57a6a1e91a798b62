rule figures:
    input:
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        friction_pair=rules.friction_pair.output.histories,
        curves=rules.fit_fragility.output.curves,
        medians=rules.fit_fragility.output.medians,
        effects=rules.fit_fragility.output.effects,
        intensity_effects=rules.fit_fragility.output.intensity_effects,
    output:
        folder=directory(FOLDER.figures),
        captions=FOLDER.captions,
    log:
        FOLDER.log("figures"),
    threads: max(1, workflow.cores // 2)  # beside `sensitivity`
    params:
        look=section("figures"),
        choices=SHOWN_CHOICES,
        digest=script_digest(
            "figures",
            rules.prepare_motions,
            rules.collect_demands,
            rules.friction_pair,
            rules.fit_fragility,
            shown=True,
        ),
    script:
        "../scripts/figures.py"


rule check_results:
    input:
        demands=rules.collect_demands.output.demands,
        curves=rules.fit_fragility.output.curves,
        effects=rules.fit_fragility.output.effects,
        suite=rules.prepare_motions.output.suite,
    output:
        checks=FOLDER.checks,
    log:
        FOLDER.log("check_results"),
    params:
        asked={
            "max_unfinished_share": STUDY.max_unfinished_share,
            "cohesion_n": STUDY.model.cohesion_n,
            "searched": STUDY.motions.design == "ida",
        },
        strict=STUDY.checks == "strict",
        suspect=section("suspect"),
        digest=script_digest(
            "check_results",
            rules.prepare_motions,
            rules.collect_demands,
            rules.fit_fragility,
        ),
    script:
        "../scripts/check_results.py"


rule report:
    input:
        captions=rules.figures.output.captions,
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        gate=rules.verify_contact.output.table,
        curves=rules.fit_fragility.output.curves,
        effects=rules.fit_fragility.output.effects,
        needed_motions=rules.fit_fragility.output.needed_motions,
        intensity_effects=rules.fit_fragility.output.intensity_effects,
        input_notes=rules.fit_fragility.output.input_notes,
        medians=rules.fit_fragility.output.medians,
        system=rules.fit_fragility.output.system,
        measures=rules.fit_fragility.output.measures,
        joint=rules.fit_fragility.output.joint,
        checks=rules.check_results.output.checks,
        sensitivity=rules.sensitivity.output.table,
    output:
        html=FOLDER.report,
    log:
        FOLDER.log("report"),
    params:
        figures=figures_folder,
        config=STUDY.model_dump(mode="json", exclude={"batches"}),
        choices=SHOWN_CHOICES,
        digest=script_digest(
            "report",
            rules.figures,
            rules.prepare_motions,
            rules.verify_contact,
            rules.collect_demands,
            rules.fit_fragility,
            rules.check_results,
            rules.sensitivity,
            shown=True,
        ),
    script:
        "../scripts/report.py"

# The page shows the table of `make choices` if it is current when the page is made.
ON_REQUEST = {"modelling_choices": MADE_FROM["modelling_choices"]}

# Snakemake sees the folder of the figures, but not whether each is still there.
if FOLDER.has_lost_figures():
    logger.warning(f"figures are missing: delete {FOLDER.figures} to draw all again")


rule figures:
    """Draw the figures of the report."""
    input:
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        curves=rules.fit_fragility.output.curves,
        medians=rules.fit_fragility.output.medians,
        system=rules.fit_fragility.output.system,
        effects=rules.fit_fragility.output.effects,
        intensity_effects=rules.fit_fragility.output.intensity_effects,
    output:
        folder=report(
            directory(FOLDER.figures),
            patterns=["{name}.svg"],
            caption="../report/figure.rst",
            category="Figures",
        ),
        captions=FOLDER.captions,
    log:
        FOLDER.log("figures"),
    benchmark:
        FOLDER.benchmark("figures")
    threads: 2
    resources:
        mem_mb=by_attempt(3000),
        runtime=by_attempt(60),
    params:
        results=results_folder,
        made_from=MADE_FROM["figures"],
        on_request=ON_REQUEST,
    script:
        "../scripts/figures.py"


rule report:
    """Combine tables and figures in one self-contained page."""
    input:
        captions=rules.figures.output.captions,
        demands=rules.collect_demands.output.demands,
        suite=rules.prepare_motions.output.suite,
        contact_checks=rules.verify_contact.output.table,
        curves=rules.fit_fragility.output.curves,
        effects=rules.fit_fragility.output.effects,
        needed_motions=rules.fit_fragility.output.needed_motions,
        intensity_effects=rules.fit_fragility.output.intensity_effects,
        input_notes=rules.fit_fragility.output.input_notes,
        medians=rules.fit_fragility.output.medians,
        system=rules.fit_fragility.output.system,
        joint=rules.fit_fragility.output.joint,
        suites=rules.fit_fragility.output.suites,
        shear_models=rules.fit_fragility.output.shear_models,
        alternatives=rules.fit_fragility.output.alternatives,
        rates=rules.fit_fragility.output.rates,
        rate_effects=rules.fit_fragility.output.rate_effects,
        checks=rules.fit_fragility.output.checks,
        sensitivity=rules.sensitivity.output.table,
    output:
        html=report(FOLDER.report, caption="../report/page.rst", category="Report"),
    log:
        FOLDER.log("report"),
    benchmark:
        FOLDER.benchmark("report")
    resources:
        mem_mb=by_attempt(3000),
        runtime=by_attempt(60),
    params:
        results=results_folder,
        made_from=MADE_FROM["report"],
        on_request=ON_REQUEST,
    script:
        "../scripts/report.py"

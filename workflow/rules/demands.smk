# The list of analyses with their keys: from it every variant tells how far the whole study is. It is
# no input of theirs, because a variant does not depend on the others; it only comes first.
rule plan:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
    output:
        plan=FOLDER.plan,
    log:
        FOLDER.log("plan"),
    priority: 100
    params:
        results=results_folder,
        variants=sorted(VARIANTS),
        sections=ANALYSIS_SECTIONS,
        bridges=BRIDGES,
        opensees=opensees_version(),
        digest=script_digest("plan", rules.prepare_motions),
    script:
        "../scripts/plan.py"


# One job per variant; joblib runs its analyses inside, on the threads of the job. The gate is an
# input to come first; where it alone has changed, the journal has every analysis.
rule analyse_variant:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        gate=rules.verify_contact.output.table,
    output:
        demands=FOLDER.variant_demands("{variant}"),
    log:
        FOLDER.log("analyse/{variant}"),
    benchmark:
        FOLDER.benchmark("{variant}")
    threads: min(2, workflow.cores)
    params:
        results=results_folder,
        sections=ANALYSIS_SECTIONS,
        bridge=lambda wildcards: BRIDGES[parse_slug(wildcards.variant).bridge],
        opensees=opensees_version(),
        digest=script_digest("analyse_variant", rules.prepare_motions),
    script:
        "../scripts/analyse_variant.py"


rule collect_demands:
    input:
        demands=collect(rules.analyse_variant.output.demands, variant=VARIANTS),
    output:
        demands=FOLDER.demands,
    log:
        FOLDER.log("collect_demands"),
    params:
        variants=sorted(VARIANTS),
        bridges=BRIDGES,
        suspect=section("suspect"),
        digest=script_digest("collect_demands", rules.analyse_variant),
    script:
        "../scripts/collect_demands.py"


# A sample of rows at the reference accuracy, and with penalties halved and doubled.
rule sensitivity:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        gate=rules.verify_contact.output.table,
    output:
        table=FOLDER.sensitivity,
    log:
        FOLDER.log("sensitivity"),
    threads: min(2, workflow.cores)
    params:
        results=results_folder,
        variants=SAMPLED,
        rows=STUDY.sensitivity.rows,
        sections=ANALYSIS_SECTIONS,
        bridges=BRIDGES,
        opensees=opensees_version(),
        digest=script_digest("sensitivity", rules.prepare_motions),
    script:
        "../scripts/sensitivity.py"


# Options of the model changed one at a time: `make choices`, on no path to the report, which shows
# the table while it is what would be made now.
CHOICES = {
    "variants": CHANGED,
    "axes": STUDY.grid.values(),
    "motions": STUDY.modelling_choices.motions,
    "sections": ANALYSIS_SECTIONS,
    "bridges": {
        name: BRIDGES[name] for name in sorted({parse_slug(s).bridge for s in CHANGED})
    },
    "opensees": opensees_version(),
}
CHOICES_DIGEST = digest_of(
    *CHOICES.items(), script_digest("modelling_choices", rules.prepare_motions)
)


rule modelling_choices:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        gate=rules.verify_contact.output.table,
    output:
        table=FOLDER.modelling_choices,
    log:
        FOLDER.log("modelling_choices"),
    threads: min(2, workflow.cores)
    params:
        results=results_folder,
        choices=CHOICES,
        made_for=CHOICES_DIGEST,
        digest=script_digest("modelling_choices", rules.prepare_motions),
    script:
        "../scripts/modelling_choices.py"


# Path of the table of modelling choices with its digest, for `params` of what shows it, if it is
# current. As an input it would be made; this way a report without it is as complete as one with it,
# and one made anew is shown at once.
SHOWN_CHOICES = {}
if is_made_for(FOLDER.modelling_choices, CHOICES_DIGEST):
    SHOWN_CHOICES = {"table": str(FOLDER.modelling_choices), "digest": CHOICES_DIGEST}


# Histories of one bridge without and with friction, to draw.
rule friction_pair:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        demands=rules.collect_demands.output.demands,
    output:
        histories=FOLDER.friction_pair,
    log:
        FOLDER.log("friction_pair"),
    params:
        results=results_folder,
        sections=ANALYSIS_SECTIONS,
        opensees=opensees_version(),
        digest=script_digest(
            "friction_pair", rules.prepare_motions, rules.collect_demands
        ),
    script:
        "../scripts/friction_pair.py"

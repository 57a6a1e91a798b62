# The list of analyses with their keys and forecast. It carries what the analyses depend on; the jobs
# that run them read it there.
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
        analyses=script_digest("analyse"),
    script:
        "../scripts/plan.py"


# One of so many parts of the planned analyses, in one pool of workers. Into how many parts a study is
# cut must not matter to what is done: a part is temporary, so that it is made only for tables that
# are to be made, and it has no parameters of its own, so that nothing is compared with an earlier
# cut. What it depends on are the parameters of the plan. The gate is an input to come first; where it
# alone has changed, the journals have every analysis.
rule analyse:
    input:
        plan=rules.plan.output.plan,
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        gate=rules.verify_contact.output.table,
    output:
        rows=temp(FOLDER.part("{part}", "{parts}")),
    log:
        FOLDER.log("analyse/{part}_of_{parts}"),
    benchmark:
        FOLDER.benchmark("analyse_{part}_of_{parts}")
    priority: 50
    threads: workflow.cores
    resources:
        no_progress_s=STUDY.batches.no_progress_s,
    script:
        "../scripts/analyse.py"


rule collect_demands:
    input:
        plan=rules.plan.output.plan,
        parts=parts_of_study,
    output:
        demands=FOLDER.demands,
        variants=[FOLDER.variant_demands(variant) for variant in sorted(VARIANTS)],
    log:
        FOLDER.log("collect_demands"),
    benchmark:
        FOLDER.benchmark("collect_demands")
    params:
        suspect=section("suspect"),
        digest=script_digest("collect_demands", rules.plan),
    script:
        "../scripts/collect_demands.py"


# A sample of rows at the reference accuracy, and with penalties halved and doubled. It comes after the
# analyses, whose rows it need not repeat, and beside the fits and figures, which leave cores idle.
rule sensitivity:
    input:
        suite=rules.prepare_motions.output.suite,
        intensities=rules.prepare_motions.output.intensities,
        demands=rules.collect_demands.output.demands,
    output:
        table=FOLDER.sensitivity,
    log:
        FOLDER.log("sensitivity"),
    priority: 10
    threads: max(1, workflow.cores // 2)
    resources:
        no_progress_s=STUDY.batches.no_progress_s,
    params:
        results=results_folder,
        variants=SAMPLED,
        rows=STUDY.sensitivity.rows,
        window_s=STUDY.sensitivity.window_s,
        sections=ANALYSIS_SECTIONS,
        bridges=BRIDGES,
        opensees=opensees_version(),
        digest=script_digest(
            "sensitivity", rules.prepare_motions, rules.collect_demands
        ),
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
    threads: workflow.cores
    resources:
        no_progress_s=STUDY.batches.no_progress_s,
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
if FOLDER.modelling_choices.is_file():
    from skewbridge.provenance.tables import is_made_for  # loads pandas

    if is_made_for(FOLDER.modelling_choices, CHOICES_DIGEST):
        SHOWN_CHOICES = {
            "table": str(FOLDER.modelling_choices),
            "digest": CHOICES_DIGEST,
        }


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

# A study with design.until runs rounds of analyses until its effects are decided. The checkpoint of
# a round lists the motions of every variant; the jobs of the round follow from this list.


checkpoint plan_round:
    """Choose the analyses of a round: those that can decide an open effect."""
    input:
        suite=FOLDER.suite,
        intensities=FOLDER.intensities,
        contact_checks=FOLDER.contact_checks,
        earlier=demands_of_rounds,
    output:
        plan=FOLDER.round("{round}"),
    log:
        FOLDER.log("plan_round/{round}"),
    benchmark:
        FOLDER.benchmark("plan_round_{round}")
    priority: 80
    resources:
        mem_mb=by_attempt(3000),
        runtime=by_attempt(30),
    params:
        results=results_folder,
        made_from=MADE_FROM["plan_round"],
        looks=STUDY.design.looks,
        hours=hours_of_round,
    script:
        "../scripts/plan_round.py"


rule analyse_round:
    """Analyse one bridge variant under its motions of one round."""
    input:
        plan=FOLDER.round("{round}"),
        suite=FOLDER.suite,
        intensities=FOLDER.intensities,
        contact_checks=FOLDER.contact_checks,
    output:
        demands=FOLDER.round_demands("{round}", "{variant}"),
    log:
        FOLDER.log("analyse/{variant}_round{round}"),
    benchmark:
        FOLDER.benchmark("analyse_{variant}_round{round}")
    priority: 50
    threads: ANALYSIS_THREADS
    resources:
        mem_mb=lambda wildcards, threads, attempt: (900 + 350 * threads) * attempt,
        runtime=by_attempt(240),
    params:
        results=results_folder,
        made_from=MADE_FROM["analyse_round"],
    script:
        "../scripts/analyse_round.py"


rule collect_rounds:
    """Join the verdicts of all rounds into one table."""
    input:
        plans=lambda wildcards: list(plans_before()),
    output:
        rounds=FOLDER.rounds,
    log:
        FOLDER.log("collect_rounds"),
    benchmark:
        FOLDER.benchmark("collect_rounds")
    resources:
        mem_mb=by_attempt(1500),
        runtime=by_attempt(30),
    params:
        results=results_folder,
        made_from=MADE_FROM["collect_rounds"],
    script:
        "../scripts/collect_rounds.py"

rule prepare_motions:
    """Read the motions, choose their scale factors, compute their intensities for every bridge."""
    output:
        suite=FOLDER.suite,
        intensities=FOLDER.intensities,
    log:
        FOLDER.log("prepare_motions"),
    benchmark:
        FOLDER.benchmark("prepare_motions")
    priority: 100
    threads: 64 if has_pilot(STUDY.motions) else 1  # Snakemake reduces this to its cores
    resources:
        mem_mb=lambda wildcards, threads, attempt: (1200 + 350 * threads) * attempt,
        runtime=by_attempt(240 if has_pilot(STUDY.motions) else 30),
    params:
        results=results_folder,
        made_from=MADE_FROM["prepare_motions"],
    script:
        "../scripts/prepare_motions.py"

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
    resources:
        mem_mb=by_attempt(1500),
        runtime=by_attempt(30),
    params:
        results=results_folder,
        made_from=MADE_FROM["prepare_motions"],
    script:
        "../scripts/prepare_motions.py"

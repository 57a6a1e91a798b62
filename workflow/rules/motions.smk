rule prepare_motions:
    output:
        suite=FOLDER.suite,
        intensities=FOLDER.intensities,
    log:
        FOLDER.log("prepare_motions"),
    params:
        results=results_folder,
        motions=section("motions"),
        content=MOTIONS,
        conditioning_t1_s=CONDITIONING_T1_S,
        t1_s=T1_S,
        digest=script_digest("prepare_motions"),
    script:
        "../scripts/prepare_motions.py"

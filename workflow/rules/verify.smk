# A gate: nothing is analysed with a broken contact law.
rule verify_contact:
    output:
        table=FOLDER.gate,
    log:
        FOLDER.log("verify_contact"),
    params:
        opensees=opensees_version(),
        digest=script_digest("verify_contact"),
    script:
        "../scripts/verify_contact.py"


# The paper's studies against their references; not part of the default target.
rule verification:
    output:
        table=FOLDER.verification / "studies.parquet",
        statements=FOLDER.verification / "statements.parquet",
    log:
        FOLDER.log("verification"),
    params:
        bridges={name: bridge_digest(name) for name in bridge_names()},
        opensees=opensees_version(),
        digest=script_digest("verification", shown=True),
    script:
        "../scripts/verification.py"

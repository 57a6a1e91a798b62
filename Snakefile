# With this file a plain `snakemake` in this folder finds the workflow and profiles/default.
include: "workflow/Snakefile"


# An included file cannot set the default target.
rule study:
    """The whole study, as `all`."""
    default_target: True
    input:
        rules.all.input,

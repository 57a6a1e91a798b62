"""What each product of the workflow is made for, told to the product."""

import json
import os
from collections.abc import Iterable, Mapping, MutableMapping
from pathlib import Path
from typing import Any, Final

from skewbridge.provenance.digests import canonical, digest_of
from skewbridge.provenance.files import write_text

#: Where the workflow keeps it in its configuration, for its scripts.
CONFIG_KEY: Final = "made_for"
#: Names a file that the workflow writes it to when it is only read.
TOLD_TO: Final = "SKEWBRIDGE_MADE_FOR"
#: Keys of the configuration that change no result.
_NO_RESULT: Final = frozenset({"results", "batches", CONFIG_KEY})


def tell_rules(
    config: MutableMapping[str, Any], params: Mapping[str, Mapping[str, Any]], suite_digest: str
) -> None:
    """Keep in the configuration of the workflow what its rules make their outputs for.

    The digest of a rule is that of its parameters, which carry those of the rules before it, the
    sources of its script and the sections of the configuration that it uses.

    Args:
        config: The configuration of the workflow.
        params: Parameters of every rule; functions among them name places and do not count.
        suite_digest: Of the motions.
    """
    used = {key: value for key, value in config.items() if key not in _NO_RESULT}
    rules = {
        rule: digest_of(*((k, canonical(v)) for k, v in sorted(own.items()) if not callable(v)))
        for rule, own in params.items()
        if own
    }
    told = {
        "config_digest": digest_of(canonical(used)),
        "suite_digest": suite_digest,
        "rules": rules,
    }
    config[CONFIG_KEY] = told
    if output := os.environ.get(TOLD_TO):
        write_text(Path(output), json.dumps(told))


def mark_outputs(rule: str, outputs: Iterable[Path], config: Mapping[str, Any]) -> None:
    """Write into the outputs of a rule what they were made with and for.

    Temporary outputs, of a rule without parameters, are not marked.
    """
    told = config[CONFIG_KEY]
    if rule not in told["rules"]:
        return
    from skewbridge.provenance.stamp import stamp
    from skewbridge.provenance.tables import provenance

    metadata = provenance(
        rule=rule,
        rule_digest=told["rules"][rule],
        config_digest=told["config_digest"],
        suite_digest=told["suite_digest"],
    )
    for output in outputs:
        stamp(output, metadata)

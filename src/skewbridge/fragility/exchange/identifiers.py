"""Names of curves as other programs take them."""

import re

from skewbridge.provenance.digests import digest_of


def identifier(name: str, signs: str, longest: int) -> str:
    """Return a name in the signs that a program takes, and not longer than it takes.

    A name that has to change ends with its digest, so that it stays unique.

    Args:
        name: Variant and component, joined by a sign that the program takes.
        signs: Class of a regular expression: the signs that it takes.
        longest: Number of signs.
    """
    plain = re.sub(f"[^{signs}]", "_", name)
    if plain == name and len(name) <= longest:
        return name
    digest = digest_of(name)
    return f"{plain[: longest - len(digest) - 1]}_{digest}"

"""What an energy balance says about an analysis: columns of the table, and words of warning."""

from collections.abc import Generator, Mapping
from math import isnan
from typing import Final

# Twenty times what the steps of a sound analysis leave; above it something is wrong with the
# solution.
MAX_TRUSTED_RESIDUAL: Final = 0.01
# Springs that close within a step store a little more or less than they were given.
MAX_CONTACT_GAIN: Final = 0.01


def energy_ratios(terms: Mapping[str, float]) -> dict[str, float]:
    """Return the columns of the table, over the largest input: residual, numerical dissipation.

    Both are nan without a balance or without input.
    """
    columns = {"energy_residual_ratio": "residual", "numerical_dissipation_ratio": "numerical"}
    largest = terms["largest_input"] if terms else 0.0
    return {
        column: terms[name] / largest if largest > 0.0 else float("nan")
        for column, name in columns.items()
    }


def energy_warnings(terms: Mapping[str, float]) -> Generator[str]:
    """Yield, in words, what is doubtful about a balance: a large residual, contacts that push."""
    residual = energy_ratios(terms)["energy_residual_ratio"]
    if isnan(residual):
        return
    if abs(residual) > MAX_TRUSTED_RESIDUAL:
        yield f"{residual:.1%} of the input energy is not accounted for"
    made = -terms["contact"] / terms["largest_input"]
    if made > MAX_CONTACT_GAIN:
        yield f"the contacts made {made:.1%} of the input energy"

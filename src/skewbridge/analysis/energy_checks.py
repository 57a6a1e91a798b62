"""What an energy balance says about an analysis: columns of the table."""

from collections.abc import Mapping


def energy_ratios(terms: Mapping[str, float]) -> dict[str, float]:
    """Return the columns of the table, over the largest input.

    The residual; what the integrator dissipates; and what the normal springs of the contacts took
    and do not store, negative if they made energy (slip, which always takes energy and would hide
    it, is left out). All are nan without a balance or without input.
    """
    columns = {
        "energy_residual_ratio": "residual",
        "numerical_dissipation_ratio": "numerical",
        "contact_energy_ratio": "contact_quadrature",
    }
    largest = terms["largest_input"] if terms else 0.0
    return {
        column: terms[name] / largest if largest > 0.0 else float("nan")
        for column, name in columns.items()
    }

"""The one settings object of all fits, effects and intervals."""

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSettings:
    """How fits and paired effects are made.

    Attributes:
        level: Confidence level of the fits.
        replicates: Of the record bootstrap.
        seed: Of everything that is drawn at random: the bootstrap and the Sobol sequence.
        accept_bounds: Give a headline number though unknown outcomes move it by over 15 %.
        assumed_beta: Dispersion for one-sided bounds where no run (or every run) exceeds.
        effect_level: Confidence level of the paired effects; 0.90 makes ``negligible`` two
            one-sided tests at 5 %.
        margin: Relative change of a demand that counts as negligible.
    """

    level: float = 0.95
    replicates: int = 999
    seed: int = 20240501
    accept_bounds: bool = False
    assumed_beta: float = 0.4
    effect_level: float = 0.90
    margin: float = 0.05  # ASSUME 5 % of demand is below what a designer would act on


DEFAULTS: Final = FitSettings()

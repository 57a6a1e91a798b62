"""The options of ``skewbridge fit``, checked against each other before any data are read."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.links import link_terms
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.limit_states import MAX_DISPERSION

METHODS: Final = ("stripes", "ida", "cloud")
MODELS: Final = ("ols", "tobit", "modified", "heteroscedastic")
MAX_ASSUMED_BETA: Final = 5.0
DEFAULT_LINK: Final = "probit"


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """Options of the command.

    Attributes:
        method: stripes, ida or cloud.
        model: Cloud model; None is ols, or modified where runs collapsed.
        link: Link of the stripes.
        level: Confidence level.
        threshold: Median capacity, if the file does not give it.
        im: Column of intensities, for a table of runs.
        edp: Column of demands, for a table of runs.
        where: Condition that selects rows of a table (`rows_where`).
        capacity_dispersion: Dispersion of the capacity (cloud ols and tobit).
        censor_above: Demands at or above it are censored (tobit).
        discard_below: Demands below it are dropped (tobit); selects on the response.
        assumed_beta: Dispersion for one-sided bounds.
        accept_bounds: Give a number though unknown outcomes move it by over 15 %.
        goodness: Add the tests of the fit whose p-values are simulated.
        columns: File that says which columns of a table are ours, for tables made elsewhere.
    """

    method: str
    model: str | None = None
    link: str = DEFAULT_LINK
    level: float = DEFAULTS.confidence
    threshold: float | None = None
    im: str | None = None
    edp: str | None = None
    where: str | None = None
    capacity_dispersion: float = 0.0
    censor_above: float | None = None
    discard_below: float | None = None
    assumed_beta: float = DEFAULTS.assumed_beta
    accept_bounds: bool = False
    goodness: bool = False
    columns: Path | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"method must be one of {', '.join(METHODS)}, got {self.method!r}")
        if self.model is not None and self.model not in MODELS:
            raise InputError(f"model must be one of {', '.join(MODELS)}, got {self.model!r}")
        widest, most = MAX_DISPERSION, MAX_ASSUMED_BETA
        for name, inside, limits in (
            ("level", 0.5 < self.level < 1.0, "0.5..1"),
            ("assumed_beta", 0.0 < self.assumed_beta <= most, f"0..{most:g} (not 0)"),
            ("capacity_dispersion", 0.0 <= self.capacity_dispersion <= widest, f"0..{widest:g}"),
        ):
            if not inside:
                raise InputError(f"{name} must be within {limits}, got {getattr(self, name):g}")
        self._refuse_what_the_method_lacks()

    def _refuse_what_the_method_lacks(self) -> None:
        """Refuse an option that the method would drop in silence."""
        if self.model is not None and self.method != "cloud":
            raise InputError(f"--model is of --method cloud, not {self.method}")
        link_terms(self.link)
        if self.link != DEFAULT_LINK and self.method != "stripes":
            raise InputError(f"--link is of --method stripes, not {self.method}")
        if self.capacity_dispersion > 0.0 and (
            self.method == "ida" or self.model in ("modified", "heteroscedastic")
        ):
            raise InputError(
                "--capacity-dispersion is of --method stripes (runs) and cloud (ols, tobit), not "
                f"{self.model or self.method}"
            )
        trimmed = self.censor_above is not None or self.discard_below is not None
        if trimmed and (self.method != "cloud" or self.model not in (None, "tobit")):
            raise InputError("--censor-above and --discard-below are of --model tobit")

    @property
    def settings(self) -> FitSettings:
        """The options that every fit takes."""
        return FitSettings(
            confidence=self.level, accept_bounds=self.accept_bounds, assumed_beta=self.assumed_beta
        )

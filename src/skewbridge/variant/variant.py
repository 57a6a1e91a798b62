"""One bridge variant of the grid: its abutment model, its values on the axes, its name."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, Self

from skewbridge.errors import InputError, did_you_mean
from skewbridge.files.text import read_mapping
from skewbridge.variant.axes import AXES, axes_of, axis


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentTraits:
    """Properties of an abutment model: its entry in abutments.yaml."""

    code: str  # two letters in the names of variants
    description: str  # continuation of "the abutments are modelled"
    #: axes of the model in addition to skew, by their names in `skewbridge.variant.axes`; the
    #: values on other axes count as zero
    axes: frozenset[str] = frozenset()
    #: curve of the backfill: ``option`` (set by the option ``backfill``), ``sdc`` or ``none``
    backfill: Literal["option", "sdc", "none"] = "option"
    #: name of the model with the same equations but no friction, or empty
    without_friction: str = ""
    #: whether elastomeric pads carry the deck end, and soil or contacts are at points along the
    #: backwall, rather than plain vertical supports and springs at the deck corners only
    has_pads: bool = False
    has_contacts: bool = False  # whether deck, backwall and keys meet in contact units
    #: whether the shear keys stand on an abutment body, which may carry the embankment mass
    has_body: bool = False

    @property
    def has_friction(self) -> bool:
        """Whether the contacts carry friction."""
        return "friction" in self.axes


def lacking_axes(abutment: str) -> frozenset[str]:
    """Return the axes that only other abutment models have; empty for an unknown model."""
    axes = frozenset[str]().union(*(traits.axes for traits in ABUTMENTS.values()))
    return axes - ABUTMENTS[abutment].axes if abutment in ABUTMENTS else frozenset()


#: Abutment models by name, from the simplest to the most complete.
ABUTMENTS: Final[Mapping[str, AbutmentTraits]] = {
    name: AbutmentTraits(**fields | {"axes": frozenset(fields.get("axes", ()))})
    for name, fields in read_mapping(Path(__file__).with_name("abutments.yaml")).items()
}

#: Pattern of the name of a bridge, which begins the name of its variants.
BRIDGE_PATTERN: Final = r"[a-z][a-z0-9_]{0,59}"


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Variant:
    """One bridge variant of the grid; whole values become integers."""

    bridge: str  # name of a bridge, for example ``osb1``, or the path of its file
    abutment: str  # abutment model, a key of `ABUTMENTS`
    skew_deg: float  # skew of the abutment line from the transverse axis, in degrees
    gap_mm: float  # opening of the joint at rest, in millimetres (option ``gap_measured``)
    friction_pct: float  # Coulomb coefficient at the contacts, in hundredths
    #: modelling options that are axes of the grid, with their values, sorted
    options: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        if self.abutment not in ABUTMENTS:
            raise InputError(
                f"abutment must be one of {', '.join(ABUTMENTS)}, got {self.abutment!r}"
                f"{did_you_mean(self.abutment, ABUTMENTS)}"
            )
        field_values = {
            "skew_deg": self.skew_deg,
            "gap_mm": self.gap_mm,
            "friction_pct": self.friction_pct / 100,
        }
        # the key of an analysis has these numbers as text, so 30 and 30.0 must be the same number
        for core, (field, value) in zip(AXES, field_values.items(), strict=True):
            object.__setattr__(self, field, core.count(value))
        for name, value in self.options:
            axis(name).checked(value)

    @classmethod
    def at(cls, bridge: str, abutment: str, values: Mapping[str, float]) -> Self:
        """Return the variant with values of skew, gap, friction and modelling options, by axis.

        Raises `InputError` for an unknown axis or an invalid value.
        """
        core = {core.name: core.count(values[core.name]) for core in AXES}
        options = {name: axis(name).checked(values[name]) for name in values if name not in core}
        return cls(
            bridge=bridge,
            abutment=abutment,
            skew_deg=core["skew_deg"],
            gap_mm=core["gap_mm"],
            friction_pct=core["friction"],
            options=tuple(sorted(options.items())),
        )

    @classmethod
    def of_row(cls, row: Mapping[str, Any]) -> Self:
        """Return the variant of a row of the demands table (name of the bridge, not its path)."""
        values = {row_axis.name: row[row_axis.name] for row_axis in axes_of(row)}
        return cls.at(str(row["bridge"]), str(row["abutment"]), values)

    @property
    def friction(self) -> float:
        """Coulomb coefficient."""
        return axis("friction").checked(self.friction_pct / 100)

    @property
    def bridge_name(self) -> str:
        """Name of the bridge in tables: name of its file without folder and ending."""
        return Path(self.bridge).stem

    @property
    def traits(self) -> AbutmentTraits:
        """Properties of the abutment model."""
        return ABUTMENTS[self.abutment]

    def values(self) -> dict[str, float]:
        """Return the value on every axis of the variant, keyed by axis name."""
        core = {"skew_deg": self.skew_deg, "gap_mm": self.gap_mm, "friction": self.friction}
        return core | dict(self.options)

    @property
    def slug(self) -> str:
        """Name of the variant, for example ``osb1_cf_skew30_gap051_mu050``."""
        parts = [axis(name).in_name(value) for name, value in self.values().items()]
        return "_".join([self.bridge_name, self.traits.code, *parts])

    def normalised(self) -> "Variant":
        """Return the variant with zero on the axes that its abutment model lacks."""
        return replace(
            self,
            gap_mm=self.gap_mm if "gap_mm" in self.traits.axes else 0,
            friction_pct=self.friction_pct if self.traits.has_friction else 0,
        )

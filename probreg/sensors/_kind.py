"""What files say of a kind of sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Kind:
    """How a kind of sensor stands in a setup file and in a table of reports.

    Parameters
    ----------
    name : str
        Of the kind, as in the setup file.
    columns : tuple of str
        Of a table, one a report component, with the unit at the end.
    sigmas : mapping of str to str
        From the key of an accuracy in the setup file, with the unit at the end, to the
        parameter of the class: one key a component, or one for all.
    coordinates : int
        Of the sensor's own place; 0 where it has none.
    maker : str
        Name of the class method that makes a sensor of these parameters; by default the class
        itself does.
    per_axis : bool
        Whether an accuracy may be a list of one an axis. Such a sensor has as many axes as the
        setup has dimensions.
    others : mapping of str to float
        Other names of the column of a single component, with SI units a unit of the cells.
    beside : float, optional
        Accuracy, SI units, that is assumed of reports found in rows of other sensors, as heights
        stand beside plots; none of a kind whose reports always have rows of their own.
    terms : tuple of str, optional
        Bias terms that are estimated unless the setup says otherwise; by default an offset of
        every report component.
    """

    name: str
    columns: tuple[str, ...]
    sigmas: Mapping[str, str]
    coordinates: int = 0
    maker: str = ""
    per_axis: bool = False
    others: Mapping[str, float] = field(default_factory=dict)
    beside: float | None = None
    terms: tuple[str, ...] | None = None

    @property
    def every_column(self) -> tuple[str, ...]:
        """Columns, and other names of them."""
        return (*self.columns, *self.others)

    def sigma_key(self, component: int) -> str:
        """Key in the setup file of the accuracy of a report component."""
        keys = tuple(self.sigmas)
        return keys[component] if len(keys) > 1 else keys[0]

    def make(self, owner: type, sigmas: Mapping[str, Any], **others: Any) -> Any:
        """A sensor of the class that owns this kind, from accuracies by key, SI units."""
        parts = {self.sigmas[key]: value for key, value in sigmas.items()}
        return (getattr(owner, self.maker) if self.maker else owner)(**parts, **others)

    def sigmas_of(self, sensor: object) -> dict[str, Any]:
        """Accuracies of a sensor by key, SI units."""
        return {key: getattr(sensor, parameter) for key, parameter in self.sigmas.items()}

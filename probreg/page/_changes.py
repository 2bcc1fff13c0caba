"""What two calibrations differ by, in words and numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from probreg.page._outputs import write_text
from probreg.page._units import SHOWN, decimals, percent
from probreg.recordings.files import replacing
from probreg.registration.differences import Differences

SURE = 0.95  # of a change, to warn of it
RARE = 1e-3  # of all differences together, if nothing changed


def in_si(value: float, unit: str) -> float:
    """A number in the unit that is shown, in the one inside."""
    return value / SHOWN[unit].factor


def changes(found: Differences) -> list[str]:
    """Warnings to read; empty if there are none."""
    said = []
    for k, name in enumerate(found.names):
        shown = SHOWN[found.units[k]]
        if np.isfinite(found.limits[k]):
            if found.exceeds[k] > SURE:
                said.append(
                    f"{name} changed by more than {shown.factor * found.limits[k]:.6g} "
                    f"{shown.symbol} (probability {percent(float(found.exceeds[k]))})."
                )
        elif found.differs[k] > SURE:
            said.append(f"{name} changed (probability {percent(float(found.differs[k]))}).")
    if not said and found.p_value < RARE and not np.isfinite(found.limits).all():
        said.append(
            f"The biases differ together (p = {found.p_value:.2g}), though no single one clearly."
        )
    return said


def changes_text(found: Differences) -> str:
    """One line a bias for a terminal, and one for all."""
    lines = []
    for k, (name, ends) in enumerate(zip(found.names, found.interval(0.9), strict=True)):
        shown = SHOWN[found.units[k]]
        places = decimals(shown.factor * float(found.sd[k]))
        mean, low, high = (f"{shown.factor * float(v):+.{places}f}" for v in (found.mean[k], *ends))
        line = f"{name:<24} {mean:>10} {shown.symbol:<5} 90 %: {low} to {high}   "
        line += f"changed: {percent(float(found.differs[k]))}"
        if np.isfinite(found.limits[k]):
            limit = f"{shown.factor * found.limits[k]:.6g} {shown.symbol}"
            line += f"   by more than {limit}: {percent(float(found.exceeds[k]))}"
        lines.append(line)
    p = len(found.names)
    lines.append(
        f"together: chi2 = {found.chi2:.1f} with {p} degrees of freedom, p = {found.p_value:.2g}"
    )
    return "\n".join(lines)


def write_changes(path: Path, found: Differences) -> None:
    """Write the numbers as JSON, SI units.

    Raises
    ------
    InvalidInputError
        A path that cannot be written.
    """
    ends = found.interval(0.9)
    rows = [
        {
            "name": name,
            "unit": found.units[k],
            "old": found.old[k],
            "new": found.new[k],
            "difference": found.mean[k],
            "sd": found.sd[k],
            "low_90": ends[k, 0],
            "high_90": ends[k, 1],
            "differs": found.differs[k],
            "limit": found.limits[k],
            "exceeds_limit": found.exceeds[k],
        }
        for k, name in enumerate(found.names)
    ]
    content = {
        "units": "SI: metres, radians, seconds; new less old",
        "differences": rows,
        "covariance": found.covariance.tolist(),
        "together": {"chi2": found.chi2, "freedom": len(rows), "p_value": found.p_value},
        "warnings": changes(found),
    }
    with replacing(path) as part:
        write_text(part, content)

"""A simulated recording as an engineer has it: `reports.csv` and `sensors.toml`."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tests.independent.scene import ANGLES, FOOT_M, Barometer, PositionReports, Radar
from tests.independent.simulate import COLUMNS, Simulated

ORDER = ("time_s", "sensor", "target", *COLUMNS, "pressure_altitude_m")
PLACE = ("latitude_deg", "longitude_deg", "height_m")
TARGET_SD = 20.0  # of constants of targets that the scene does not have
RADAR_KEYS = (*PLACE, "sigma_range_m", "sigma_azimuth_deg", "sigma_elevation_deg")


def write(
    simulated: Simulated, folder: str | Path, asked: Mapping[str, tuple[str, ...]] | None = None
) -> None:
    """Write both files into a folder that is there.

    Columns that no report uses are left out. The setup file asks for the terms that each sensor
    has, or for those in `asked` by name of sensor: a wrong model, on purpose. Those of "targets"
    are constants of each target.
    """
    folder = Path(folder)
    columns = {name: simulated.reports[name] for name in ORDER}
    used = [name for name, values in columns.items() if any(_cell(one) for one in values)]
    rows = zip(*(map(_cell, columns[name]) for name in used), strict=True)
    with (folder / "reports.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(used)
        writer.writerows(rows)
    scene, asked = simulated.scene, asked or {}
    origin = zip(PLACE, (*scene.centre_deg, 0.0), strict=True)
    lines = ["origin = {" + ", ".join(f"{key} = {value}" for key, value in origin) + "}"]
    own = asked.get("targets", ("range",) if scene.delay_sd_m else ())
    if own:
        spreads = ", ".join(f"{t}{_ending(t)} = {scene.delay_sd_m or TARGET_SD}" for t in own)
        lines.append(f"target_terms = {{{spreads}}}")
    for sensor in (*scene.sensors, *((scene.barometer,) if scene.barometer else ())):
        terms = asked.get(sensor.name, tuple(sensor.unknown))
        lines += [
            "",
            "[[sensor]]",
            f'name = "{sensor.name}"',
            *_kind(sensor),
            *_terms(sensor, terms),
        ]
    (folder / "sensors.toml").write_text("\n".join(lines) + "\n")


def _cell(value: object) -> str:
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else repr(float(value))


def _kind(sensor: Radar | PositionReports | Barometer) -> list[str]:
    if isinstance(sensor, Barometer):
        rounded = sensor.sigma_m**2 + (max(sensor.step_ft) * FOOT_M) ** 2 / 12.0
        sd = round(float(np.sqrt(rounded + sensor.aircraft_sigma_m**2)), 3)
        return ['kind = "barometer"', f"sigma_height_m = {sd}"]
    if isinstance(sensor, PositionReports):
        sigmas = [sensor.sigma_m, sensor.sigma_m, sensor.sigma_height_m]
        return ['kind = "position"', f"sigma_m = {sigmas}"]
    keys = RADAR_KEYS if sensor.sigma_elevation_deg else RADAR_KEYS[:-1]
    kind = "radar3d" if sensor.sigma_elevation_deg else "radar2d"
    bent = "standard" if sensor.refraction else "none"
    numbers = (f"{key} = {getattr(sensor, key)}" for key in keys)
    return [f'kind = "{kind}"', *numbers, f'refraction = "{bent}"']


def _terms(sensor: Radar | PositionReports | Barometer, terms: tuple[str, ...]) -> list[str]:
    if not terms:
        return ["reference = true"]
    given = ", ".join(
        f"{term}{_ending(term)} = {sensor.unknown[term]}"
        for term in terms
        if term in sensor.unknown
    )
    names = ", ".join(f'"{term}"' for term in terms)
    return [f"biases = [{names}]", f"prior_sd = {{{given}}}"]


def _ending(term: str) -> str:
    plain = {"time": "_s", "range_gain": "", "height_gain": ""}
    return "_deg" if term in ANGLES else plain.get(term, "_m")

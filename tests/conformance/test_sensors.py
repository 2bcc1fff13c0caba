"""Every kind of sensor there is, found by discovery: physics, derivatives, noise, frames, files.

Sensors that are broken on purpose fail.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from probreg import recordings, sensors
from probreg.discovery import public_classes
from probreg.errors import InvalidInputError
from probreg.recordings import Recording, Setup, new_table, setup_file
from probreg.sensors import kinds, known_kinds
from tests.conformance import sensor_facts as facts
from tests.conformance.sensor_facts import FACTS, IDS, SENSORS, declared, difference, made, scene


def test_every_kind_of_the_package_is_here_and_named_once():
    found = set(public_classes(kinds))
    assert found == {type(sensor).__name__ for sensor in SENSORS}
    assert found <= set(sensors.__all__)
    assert len(known_kinds()) == len(found)


@pytest.mark.parametrize("fact", FACTS, ids=lambda fact: fact.__name__)
@pytest.mark.parametrize("sensor", SENSORS, ids=IDS)
def test_a_sensor(sensor, fact):
    fact(sensor)


# -- sensors that are wrong on purpose ---------------------------------------------------


def broken(sensor, **members):
    """The same sensor with some members of its class replaced."""
    values = {field.name: getattr(sensor, field.name) for field in dataclasses.fields(sensor)}
    return type("Broken", (type(sensor),), members)(**values)


def altered(sensor, name, change):
    """A method whose result is changed."""
    old = getattr(type(sensor), name)
    return broken(sensor, **{name: lambda self, *a, **k: change(old(self, *a, **k))})


def _part(name, factor):
    return lambda seen: seen._replace(**{name: factor * getattr(seen, name)})


def _blind(sensor):
    old = type(sensor).observe
    return broken(sensor, observe=lambda self, z, at=None, own=None: old(self, z, at, None))


WRONG = {
    "wrong sign of a bias": (
        lambda s: altered(s, "observe", _part("D", -1.0)),
        facts.has_the_derivatives_it_says,
    ),
    "bias one part in a thousand off": (
        lambda s: altered(s, "observe", _part("D", 1.001)),
        facts.has_the_derivatives_it_says,
    ),
    "wrong sign of the target": (
        lambda s: altered(s, "observe", _part("G", -1.0)),
        facts.has_equations_that_hold,
    ),
    "variances a twentieth too large": (
        lambda s: altered(s, "observe", _part("C", 1.05)),
        facts.has_the_noise_it_says,
    ),
    "noise a twentieth too large": (
        lambda s: altered(s, "sample_noise", lambda noise: 1.05 * noise),
        facts.has_the_noise_it_says,
    ),
    "reports of the wrong sign": (
        lambda s: altered(s, "to_report", lambda z: -z),
        facts.reports_by_the_physics,
    ),
    "blind for the platform": (_blind, facts.has_equations_that_hold),
    "nothing refused": (
        lambda s: broken(s, check=lambda self, z: z),
        facts.refuses_what_cannot_be_meant,
    ),
    "no default prior": (
        lambda s: broken(s, bias_sd=np.zeros(len(s.bias_names))),
        facts.describes_itself,
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("sensor", SENSORS, ids=IDS)
def test_a_sensor_that_is_wrong_is_found_out(sensor, wrong):
    change, fact = WRONG[wrong]
    with pytest.raises((AssertionError, pytest.fail.Exception)):
        fact(change(sensor))


@pytest.mark.parametrize(
    "sensor", [s for s in SENSORS if s.azimuth_column is not None], ids=lambda s: s.kind.name
)
def test_a_sensor_that_counts_the_other_way_than_it_says_is_found_out(sensor):
    old = type(sensor).to_report
    other = dataclasses.replace(sensor, from_north=not sensor.from_north)
    liar = broken(sensor, to_report=lambda self, x, own=None: old(other, x, own))
    for fact in (facts.reports_by_the_physics, facts.counts_azimuth_as_it_says):
        with pytest.raises(AssertionError):
            fact(liar)


# -- files ---------------------------------------------------------------------------------


def pair(sensor):
    """A recording of the sensor and a namesake on the same targets, on a moving platform."""
    x, own = (np.repeat(part, 2, axis=0) for part in scene(sensor))
    both = sensor, dataclasses.replace(sensor, name="t")
    own = own if sensor.position is None and not sensor.cartesian else np.zeros_like(own)
    n = len(x)
    return Recording(
        both,
        np.arange(n) % 2,
        np.arange(n) // 2 * 1.0,
        sensor.to_report(x, own),
        np.arange(n) // 2 % 5,
        ("a", "b", "c", "d", "e"),
        own if own.any() else None,
    )


@pytest.mark.parametrize("sensor", SENSORS, ids=IDS)
def test_a_sensor_survives_the_setup_file(tmp_path, sensor):
    everything = {sensor.name: tuple(sensor.bias_names)}
    units = dict(zip(sensor.bias_names, sensor.bias_units, strict=True))
    sd = {f"{sensor.name}.{name}": 0.01 if unit == "rad" else 5.0 for name, unit in units.items()}
    moving = frozenset({sensor.name} if sensor.azimuth_column is not None else ())
    others = made("radar3d" if sensor.dim == 3 else "radar2d")
    both = sensor, dataclasses.replace(others, name="other")
    setup = Setup(both, everything, sd, moving, limits=sd)
    setup_file.write(tmp_path / "sensors.toml", setup)
    again = setup_file.read(tmp_path / "sensors.toml")
    assert type(again.sensors[0]) is type(sensor)
    for field in dataclasses.fields(sensor):
        one, two = (getattr(s, field.name) for s in (sensor, again.sensors[0]))
        assert two == (one if isinstance(one, str | bool) else pytest.approx(np.array(one)))
    assert again.biases[sensor.name] == everything[sensor.name]
    assert again.prior_sd == pytest.approx(sd, rel=1e-12)
    assert again.limits == pytest.approx(sd, rel=1e-12)
    assert again.body_frame == moving


@pytest.mark.parametrize("origin", [None, (55.0, 9.0, 20.0)], ids=["plane", "earth"])
@pytest.mark.parametrize("sensor", SENSORS, ids=IDS)
def test_its_reports_survive_a_table(tmp_path, sensor, origin):
    recording = pair(sensor)
    setup = Setup(recording.sensors, {}, origin=origin)
    new_table.create(tmp_path / "r.csv", recording, setup)
    again = recordings.read(tmp_path / "r.csv", setup).recording
    away = difference(sensor, again.values, recording.values)
    np.testing.assert_allclose(away, 0.0, atol=1e-9)
    np.testing.assert_array_equal(again.sensor, recording.sensor)
    header = (tmp_path / "r.csv").read_text().splitlines()[0].split(",")
    assert set(sensor.kind.columns[: len(sensor.bias_names)]) <= set(header)


def test_errors_that_correlate_and_lists_for_one_number_are_refused():
    table = declared("tracker2d") | {"sigma_m": [1.0, 2.0]}
    with pytest.raises(InvalidInputError, match="sigma_m of sensor 's'"):
        setup_file.parse({"sensor": [table]})

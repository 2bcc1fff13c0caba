"""What a registration found, in plain words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from probreg.page._units import SHOWN, decimals, number, percent
from probreg.registration import MissingTerm, Registration

LEFT_OUT = 0.2  # share of a sensor's reports that contradict the others
TOGETHER = 1.8  # clustered standard deviation over the posterior's; sound recordings 0.5 to 1.3
NOISE = (0.5, 2.0)  # scales of the noise beyond which declared accuracies are wrong
GUESSES = (
    "Are stamps rounded, are ranges slant ranges? If the error is a target's own, such as the "
    "delay of its transponder, allow for it by target_terms."
)


ENDINGS = {"m": "_m", "s": "_s", "rad": "_deg"}  # of keys of sensors.toml


class Wording(NamedTuple):
    """How a bias is spoken of: what is wrong, and how when it is above or below zero."""

    what: str
    above: str
    below: str


WORDS: Mapping[str, Wording] = {
    "range": Wording("range", "too long", "too short"),
    "range_gain": Wording("range, in proportion to it,", "too long", "too short"),
    "azimuth": Wording("azimuth", "too large", "too small"),
    "elevation": Wording("elevation", "too high", "too low"),
    "bearing": Wording("bearing", "too large", "too small"),
    "x": Wording("position", "too far east", "too far west"),
    "y": Wording("position", "too far north", "too far south"),
    "z": Wording("height", "too high", "too low"),
    "height": Wording("height", "too high", "too low"),
    "height_gain": Wording("height, in proportion to it,", "too high", "too low"),
    "time": Wording("clock", "ahead", "behind"),
    "heading": Wording("heading", "too large", "too small"),
}


class Sentence(NamedTuple):
    """One bias in words."""

    sensor: str
    error: str
    subtract: str
    clear: bool


def wording(term: str) -> Wording:
    """Words for a term, plain ones for a term without its own."""
    return WORDS.get(term, Wording(term.replace("_", " "), "above zero", "below zero"))


def sentences(registration: Registration) -> list[Sentence]:
    """Every bias with its 90 % interval, and what to take out."""
    found = []
    numbers = zip(registration.mean, registration.sd, registration.interval(0.9), strict=True)
    for name, unit, (mean, sd, interval) in zip(
        registration.names, registration.units, numbers, strict=True
    ):
        sensor, term = name.split(".", 1)
        shown, said = SHOWN[unit], wording(term)
        places = decimals(shown.factor * sd)
        low, high = (number(shown.factor * float(v), places) for v in interval)
        size = number(shown.factor * abs(float(mean)), places)
        clear = bool(np.sign(interval[0]) == np.sign(interval[1]))
        if clear:
            low, high = (number(shown.factor * v, places) for v in sorted(np.abs(interval)))
            way = said.above if mean > 0.0 else said.below
            error = f"{said.what} {size} {shown.symbol} {way}"
        else:
            error = f"{said.what} shows no clear error"
        if name in registration.drifting:
            found.append(_moving(registration, name, sensor, said))
            continue
        amount = number(shown.factor * float(mean), places)
        found.append(
            Sentence(
                sensor,
                f"{error} (90\N{NO-BREAK SPACE}%: {low} to {high} {shown.symbol})",
                f"{amount} {shown.symbol}",
                clear,
            )
        )
    return found


def _moving(registration: Registration, name: str, sensor: str, said: Wording) -> Sentence:
    """A bias that may drift: what it is between."""
    k = registration.names.index(name)
    paths, shown = registration.draws.paths, SHOWN[registration.units[k]]
    assert paths is not None
    j = paths.number.index(k)
    path = shown.factor * paths.flat[..., j]
    places = decimals(float(path.std(axis=0).mean()))
    mean = path.mean(axis=0)
    low, high = (number(float(v), places) for v in (mean.min(), mean.max()))
    error = f"{said.what} moves between {low} and {high} {shown.symbol}"
    none = percent(float(paths.constant[j]))
    return Sentence(
        sensor,
        f"{error} (probability that it does not drift: {none})",
        "the path of biases.csv",
        True,
    )


def matters(registration: Registration) -> list[str]:
    """Warnings to read before the result is used, causes first; empty if there are none."""
    said = [
        f"{v.name} exceeds its limit of {limit_text(registration, v.name, v.limit)} "
        f"(probability {percent(v.probability)})."
        for v in registration.verdicts
        if v.text == "exceeds"
    ]
    said += _left_out(registration) + _missing(registration) + _model(registration)
    said += [f"Do not trust the draws: {text}" for text in registration.draws.warnings]
    told = registration.determined
    said += [f"No residual shows {text}: only the prior determines it." for text in told.hidden]
    said += [
        f"The prior determines {text} more than the data do."
        for text in told.weak
        if text not in told.hidden
    ]
    return said


def _left_out(registration: Registration) -> list[str]:
    """Sensors whose reports are of none of the targets that they name, worst first."""
    share = registration.left_out
    return [
        f"{registration.recording.sensors[k].name}: {100.0 * share[k]:.0f} % of its reports fit no "
        "target: check units, north, place, identities."
        for k in np.argsort(-share, kind="stable")
        if share[k] > LEFT_OUT
    ]


def _missing(registration: Registration) -> list[str]:
    """Terms that the setup leaves out, with what to write into it."""
    return [
        _own_error(one) if one.of_targets else _missing_bias(registration, one)
        for one in registration.missing
    ]


def _missing_bias(registration: Registration, one: MissingTerm) -> str:
    return (
        f"The recording asks for {one.name}, which sensors.toml leaves out (chi-square "
        f"{one.chi2:.0f}): it would be {_amount(one.unit, one.value, one.sd)}. "
        f"{_remedy(registration, one.name)}"
    )


def _own_error(one: MissingTerm) -> str:
    term = one.name.split(".", 1)[1]
    key = f"{term}{ENDINGS[one.unit]} = {_plain(one.unit, one.value)}"
    return (
        f"Targets have {wording(term).what} errors of their own (z {np.sqrt(one.chi2):.0f}), about "
        f"{_size(one.unit, one.value)} from one to another, that sensors.toml does not allow for. "
        f"Add target_terms = {{{key}}} to it."
    )


def _size(unit: str, sd: float) -> str:
    """A standard deviation in engineers' units, two digits."""
    return f"{_plain(unit, sd)} {SHOWN[unit].symbol}"


def _plain(unit: str, sd: float) -> str:
    return f"{float(f'{SHOWN[unit].factor * sd:.2g}'):g}"


def _amount(unit: str, value: float, sd: float) -> str:
    """A value with its standard deviation, in engineers' units."""
    shown = SHOWN[unit]
    places = decimals(shown.factor * sd)
    mean, spread = (number(shown.factor * one, places) for one in (value, sd))
    return f"{mean} {shown.symbol}".rstrip() + f" (sd {spread})"


def _remedy(registration: Registration, name: str) -> str:
    owner, term = name.split(".", 1)
    sensors = [sensor.name for sensor in registration.recording.sensors]
    where = owner if owner in sensors else " and ".join(sorted(registration.setup.body_frame))
    return f'Add "{term}" to the biases of {where}.'


def _model(registration: Registration) -> list[str]:
    """Evidence against the assumed biases, noise or independence."""
    said = []
    scored, ratio = registration.held_out, registration.cluster_ratio
    if scored is not None and scored.verdict == "worse":
        said.append(
            "Held-out targets are predicted worse after correction than before: the biases of "
            "sensors.toml do not describe this recording."
        )
    if np.isfinite(ratio).all() and ratio.max(initial=0.0) > TOGETHER:
        worst = int(np.argmax(ratio))
        said.append(
            "Errors of one target's reports are correlated: intervals are about "
            f"{ratio[worst]:.1f} times too narrow ({registration.names[worst]} the most). "
            + ("What is missing may be why." if registration.missing else GUESSES)
        )
    # reports scatter more where a term is missing: accuracies would only hide it
    return said if registration.missing else said + _noise(registration)


def _noise(registration: Registration) -> list[str]:
    """Sensors whose noise is far from what they declare."""
    sensors, scales = registration.recording.sensors, registration.noise_scale.tolist()
    return [
        f"The noise of {sensor.name} is {bulk if bulk > NOISE[1] else every:.2g} times what it "
        "declares: check its accuracies."
        for sensor, (bulk, every) in zip(sensors, scales, strict=True)
        if bulk > NOISE[1] or every < NOISE[0]
    ]


def limit_text(registration: Registration, name: str, limit: float) -> str:
    """A limit in engineers' units."""
    shown = SHOWN[registration.units[registration.problem.model.numbers[name]]]
    return f"{shown.factor * limit:.6g} {shown.symbol}"


def biases_text(registration: Registration) -> str:
    """One line a bias for a terminal: mean and 90 % interval."""
    lines = []
    interval = registration.interval(0.9)
    for k, name in enumerate(registration.names):
        shown = SHOWN[registration.units[k]]
        places = decimals(shown.factor * float(registration.sd[k]))
        values = (registration.mean[k], *interval[k])
        mean, low, high = (f"{shown.factor * float(v):.{places}f}" for v in values)
        moves = "  average: it drifts" if name in registration.drifting else ""
        lines.append(f"{name:<24} {mean:>10} {shown.symbol:<5} 90 %: {low} to {high}{moves}")
    return "\n".join(lines)

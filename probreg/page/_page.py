"""The page: every section's content, put into the template."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from functools import partial
from importlib import resources
from typing import Any

import jinja2
import numpy as np

from probreg.page import _drift, _figures, _scene, _tables
from probreg.page._provenance import Provenance, versions
from probreg.page._units import Number, number
from probreg.page._words import Sentence, matters, sentences
from probreg.problems.observability import Observability
from probreg.recordings import places
from probreg.registration import HeldOut, RankedTerms, Registration
from probreg.typing import IntArray


def render(
    registration: Registration,
    provenance: Provenance,
    *,
    row_name: Callable[[int], str],
    terms: Sequence[RankedTerms] = (),
) -> str:
    """The whole page as text.

    Parameters
    ----------
    registration : Registration
    provenance : Provenance
    row_name : callable
        From the number of a report to what the reader knows it by.
    terms : sequence of RankedTerms
        Bias models compared, if they were.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("probreg.page", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["number"] = lambda cell: isinstance(cell, Number)
    style = resources.files("probreg.page").joinpath("page.css").read_text(encoding="utf-8")
    content = {
        **_header(registration, provenance),
        **_found(registration),
        **_drift.drifting(registration),
        **_reports(registration),
        **_noise(registration, row_name),
        "terms": terms_table(terms) if terms else None,
        "provenance": provenance,
        "versions": versions(),
        "seconds": [(step, number(s, 2)) for step, s in registration.seconds.items()],
        "notes": (*provenance.notes, *registration.notes),
    }
    return environment.get_template("page.html").render(style=style, **content)


def _header(registration: Registration, provenance: Provenance) -> dict[str, Any]:
    recording = registration.recording
    sensors = [sensor.name for sensor in recording.sensors]
    counts = np.bincount(recording.sensor, minlength=len(sensors))
    listed = zip(sensors, counts.tolist(), strict=True)
    duration = datetime.timedelta(seconds=round(float(np.ptp(recording.time))))
    return {
        "sensors": sensors,
        "files": ", ".join(provenance.inputs),
        "counts": "; ".join(
            f"{name} {count:,}, used {registration.used[name]:,}" for name, count in listed
        ),
        "reports": len(recording),
        "targets": len(np.unique(recording.target[recording.target >= 0])),
        "duration": str(duration),
        "tracks": len(registration.problem.owner),
    }


def _found(registration: Registration) -> dict[str, Any]:
    said: dict[str, list[Sentence]] = {}
    for sentence in sentences(registration):
        said.setdefault(sentence.sensor, []).append(sentence)
    setup = registration.setup
    told = registration.determined
    return {
        "said": said,
        "alarms": matters(registration),
        "references": [s.name for s in setup.sensors if not setup.biases.get(s.name)],
        "biases": _tables.biases(registration),
        "correlation": _tables.correlation(registration),
        "heat_map": _figures.heat_map(registration),
        "marginals": _figures.marginals(registration),
        "pairs": _figures.pairs(registration),
        "paired": len(_figures.strongest(registration)),
        "verdicts": _tables.verdicts(registration),
        "hidden": told.hidden,
        "weak": [text for text in told.weak if text not in told.hidden],
        "equations": told.observability.equations,
        "strength": _strength(told.observability),
        "convergence": _tables.convergence(registration),
        "priors": _tables.priors(registration),
        "facts": registration.draws.facts,
        "sampler": registration.draws.sampler,
        "draw_warnings": registration.draws.warnings,
    }


def _strength(found: Observability) -> str | None:
    """How much more strongly the best seen combination shows than the worst."""
    values = found.singular_values
    return f"{values[0] / values[-1]:.3g}" if found.complete else None


def _reports(registration: Registration) -> dict[str, Any]:
    """What concerns single reports, before and after correction."""
    recording, found = registration.recording, registration.components
    after = registration.residuals
    before = places(recording, registration.setup, recording.values)
    target, label = _believed(registration), partial(_tables.label, registration)
    scored = registration.held_out
    return {
        "held_out": _tables.held_out(registration),
        "medians": _medians(scored),
        "held_out_panels": [] if scored is None else _figures.held_out(scored),
        "overview": _scene.overview(recording, target, after),
        "maps": _scene.maps(recording, target, before, after, label),
        "residuals": _tables.residuals(found),
        "residual_panels": _scene.against(recording, after, found),
        "all_components": len(found) <= _scene.COMPONENTS,
        "dots": _scene.DOTS,
        "most": _scene.MOST,
    }


def _believed(registration: Registration) -> IntArray:
    """Target (n,) that each report of the recording is believed to be of, -1 for none."""
    problem, fit = registration.problem, registration.fit
    target = np.full(len(registration.recording), -1)
    good = fit.wrong <= 0.5
    target[problem.rows[good]] = problem.owner[fit.target[good]]
    return target


def _medians(scored: HeldOut | None) -> list[str] | None:
    """Before and after, None where nothing was held out."""
    if scored is None or not np.isfinite(scored.before_m).any():
        return None
    return [f"{median:.3g}" for median in scored.medians_m]


def _noise(registration: Registration, row_name: Callable[[int], str]) -> dict[str, Any]:
    return {
        "laws": _tables.laws(registration),
        "law": registration.law,
        "noise": _tables.noise(registration),
        "outliers": int((registration.bad > 0.5).sum()),
        "outliers_expected": number(registration.expected_outliers, 1),
        "tracked": len(registration.problem.rows),
        "suspects": _tables.suspects(registration, row_name),
    }


def terms_table(terms: Sequence[RankedTerms]) -> _tables.Table:
    """Bias models by how they predict targets they have not seen."""
    rows: list[tuple[_tables.Cell, ...]] = [
        (
            one.name,
            str(one.unknowns),
            number(one.log_score, 1),
            number(one.behind, 1),
            number(one.standard_error, 1),
        )
        for one in terms
    ]
    columns = ("bias model", "unknowns", "log score", "behind the best", "standard error")
    caption = "Bias models by the log predictive density of targets held out in turn, best first."
    return _tables.Table("terms-table", caption, columns, rows)

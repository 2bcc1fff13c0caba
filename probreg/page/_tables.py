"""Tables of a report: rows ready to be shown, the exact number beside what is printed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from probreg.page._noise import noise_kinds, target_spreads
from probreg.page._units import SHOWN, Number, decimals, number, percent
from probreg.page._words import limit_text
from probreg.recordings import TARGET_HEIGHT_M
from probreg.registration import Registration
from probreg.registration.residuals import Component
from probreg.typing import FloatArray

WORST = 20  # reports listed

Cell = str | Number


class Table(NamedTuple):
    """A table with a caption, names of columns, and rows whose first cell names them."""

    id: str
    caption: str
    columns: tuple[str, ...]
    rows: list[tuple[Cell, ...]]


def biases(registration: Registration) -> Table:
    """Biases in engineers' units."""
    half, most = registration.interval(0.5), registration.interval(0.9)
    rows: list[tuple[Cell, ...]] = []
    for k, name in enumerate(registration.names):
        shown = SHOWN[registration.units[k]]
        values = (registration.mean[k], registration.sd[k], *half[k], *most[k])
        places = decimals(shown.factor * float(registration.sd[k]))
        cells = [number(shown.factor * float(value), places) for value in values]
        told = registration.determined.share[k]
        rows.append((name, shown.symbol, *cells, percent(float(told))))
    return Table(
        "bias-table",
        "Biases: what each sensor adds to the truth. Subtract the mean.",
        (
            "bias",
            "unit",
            "mean",
            "sd",
            "50 % from",
            "50 % to",
            "90 % from",
            "90 % to",
            "determined by data",
        ),
        rows,
    )


def correlation(registration: Registration) -> Table:
    """Correlations as numbers."""
    values = registration.correlation
    rows: list[tuple[Cell, ...]] = [
        (name, *(number(float(value), 2) for value in values[k]))
        for k, name in enumerate(registration.names)
    ]
    caption = "Posterior correlation of the biases."
    return Table("correlation-table", caption, ("bias", *registration.names), rows)


def verdicts(registration: Registration) -> Table:
    """Biases against the limits of the setup."""
    rows: list[tuple[Cell, ...]] = []
    for verdict in registration.verdicts:
        limit = limit_text(registration, verdict.name, verdict.limit)
        rows.append((verdict.name, limit, percent(verdict.probability), verdict.text))
    columns = ("bias", "limit", "probability of exceeding", "verdict")
    return Table("limit-table", "Limits of sensors.toml, judged at 95 %.", columns, rows)


def laws(registration: Registration) -> Table:
    """Noise laws by leave-one-out."""
    rows: list[tuple[Cell, ...]] = [
        (
            law.name,
            number(law.elpd, 1),
            number(law.behind, 1),
            number(law.standard_error, 1),
            "yes" if law.name == registration.law else "",
        )
        for law in registration.laws
    ]
    columns = ("law", "elpd", "behind the best", "standard error", "used")
    caption = (
        f"Noise laws by the log density of each of {registration.law_reports:,} reports given all "
        "others, best first. Used is the first, in the order in which they were given, that is as "
        "good as the best within the standard error."
    )
    if len(registration.laws) == 1:
        caption = "The noise law that was asked for; no other was compared with it."
    return Table("law-table", caption, columns, rows)


def noise(registration: Registration) -> Table:
    """Parameters of the law of each sensor."""
    kinds = noise_kinds(registration)
    names = list(dict.fromkeys(name for kind in kinds for name in kind.parameters))
    rows: list[tuple[Cell, ...]] = []
    for kind in kinds:
        own = (number(kind.parameters.get(name, np.nan), 3) for name in names)
        said = registration.noise_scale[kind.sensor].tolist()
        scales = (number(scale, 2) for scale in said)
        rows.append((kind.name, *own, percent(kind.wrong), *scales))
    columns = ("sensor", *names, "wrong identities", "bulk over declared", "all over declared")
    caption = (
        f"Noise of each sensor under the law {registration.law}: its parameters at the mode, the "
        "share of reports that are of another target than they say, and the standard deviation of "
        "most reports, and of all with their tails, over the declared one."
    )
    return Table("noise-table", caption, columns, rows)


def suspects(registration: Registration, row_name: Callable[[int], str]) -> Table:
    """Reports most likely to be outliers or under a wrong identity."""
    found = registration.suspects().head(WORST)
    rows: list[tuple[Cell, ...]] = []
    for one in found.to_dict("records"):
        fits = int(one["fits target"])
        rows.append(
            (
                row_name(one["report"]),
                one["sensor"],
                number(float(one["time"]), 3),
                label(registration, one["target"]),
                percent(one["probability"]),
                percent(one["other target"]),
                "none" if fits < 0 else label(registration, fits),
            )
        )
    columns = (
        "report",
        "sensor",
        "time, s",
        "names target",
        "is wrong",
        "is of another target",
        "fits target",
    )
    caption = (
        f"Reports that are most likely wrong (at most {WORST}, the worst first): much noisier than "
        "their sensor usually is, or of another target than they name."
    )
    return Table("suspect-table", caption, columns, rows)


def label(registration: Registration, target: int) -> str:
    """What the recording calls a target."""
    labels = registration.recording.labels
    return labels[target] if target < len(labels) else str(target)


def held_out(registration: Registration) -> Table | None:
    """Residuals of targets held out, before and after."""
    scored = registration.held_out
    if scored is None:
        return None
    rows: list[tuple[Cell, ...]] = []
    for kind, before, after, places in (
        ("m", scored.before_m, scored.after_m, 1),
        ("standard deviations", scored.before_sd, scored.after_sd, 2),
    ):
        for what, share in (("median", 0.5), ("90 % of reports below", 0.9)):
            cells = (number(_quantile(v, share), places) for v in (before, after))
            rows.append((f"{what}, {kind}", *cells))
    scores = (scored.before_log_score, scored.after_log_score)
    rows.append(("mean log predictive density of a report", *(number(s, 2) for s in scores)))
    caption = (
        f"Residuals of {len(scored.rows):,} reports of {scored.targets} targets held out: "
        "corrected with biases that the other targets gave."
    )
    return Table("held-out-table", caption, ("residual", "before", "after"), rows)


def _quantile(values: FloatArray, share: float) -> float:
    """Of the values that are there."""
    values = values[np.isfinite(values)]
    return float(np.quantile(values, share)) if values.size else float("nan")


def residuals(found: Sequence[Component]) -> Table:
    """Residuals of the reports of each sensor against the tracks."""
    rows: list[tuple[Cell, ...]] = []
    for one in found:
        shown = SHOWN[one.unit]
        before, after = one.spreads
        places = decimals(shown.factor * after.sd)
        expected = float(np.median(one.sd))
        values = (before.median, after.median, before.sd, after.sd, expected)
        cells = (number(shown.factor * value, places) for value in values)
        rows.append((f"{one.sensor}: {one.name}", shown.symbol, f"{len(one.rows):,}", *cells))
    columns = (
        "component",
        "unit",
        "reports",
        "median before",
        "median after",
        "spread before",
        "spread after",
        "spread expected",
    )
    caption = "Reports less what the path by all other reports of their target says."
    return Table("residual-table", caption, columns, rows)


def convergence(registration: Registration) -> Table:
    """R-hat and effective draws of every bias."""
    draws = registration.draws
    found = draws.convergence
    rows: list[tuple[Cell, ...]] = [
        (
            name,
            number(float(found.r_hat[k]), 3),
            number(float(found.ess_bulk[k]), 0),
            number(float(found.ess_tail[k]), 0),
        )
        for k, name in enumerate(draws.names)
    ]
    chains, length = draws.theta.shape[:2]
    caption = f"{chains * length} draws in {chains} chains by {draws.sampler}."
    columns = ("unknown", "R-hat", "effective draws, bulk", "effective draws, tail")
    return Table("convergence-table", caption, columns, rows)


def priors(registration: Registration) -> Table:
    """What was believed before the data, and what became of it where no other table says so."""
    rows: list[tuple[Cell, ...]] = []
    problem, model, setup = registration.problem, registration.fit.model, registration.setup
    for name, unit, sd in zip(problem.names, problem.units, problem.prior_sd, strict=True):
        rows.append((name, f"normal, 0 ± {in_units(unit, float(sd))}", ""))
    for law, unknown in zip(model.laws[:1], model.unknown or (), strict=False):
        for name in sorted(unknown):
            about = f"about {float(getattr(law, name)):g}, a sensor"
            rows.append((f"noise: {name}", about, "see noise"))
    factor = np.exp(0.5 * model.acceleration_log_sd)
    rows.append(
        (
            "acceleration of targets over one second",
            f"log-normal, {setup.acceleration_m_s2:g} m/s², a factor of {factor:.1f} either way",
            f"{np.sqrt(registration.fit.point.q):.3g} m/s²",
        )
    )
    rows.append(
        ("share of wrong identities", f"about {model.wrong_share:g}, a sensor", "see noise")
    )
    if problem.reports.dim == 3:
        mean, sd = setup.target_height or TARGET_HEIGHT_M
        rows.append(("height of a target when first seen", f"normal, {mean:g} ± {sd:g} m", ""))
    rows += target_terms(registration)
    return Table("prior-table", "Priors.", ("unknown", "prior", "found"), rows)


def target_terms(registration: Registration) -> list[tuple[Cell, ...]]:
    """Errors that belong to single targets: their spread as expected and as found."""
    return [
        (
            f"{name} of a target's own",
            f"normal, spread about {in_units(unit, expected)}",
            f"spread {in_units(unit, found)}",
        )
        for name, unit, expected, found in target_spreads(registration)
    ]


def in_units(unit: str, value: float) -> str:
    """A value in engineers' units."""
    shown = SHOWN[unit]
    return f"{shown.factor * value:.4g} {shown.symbol}".rstrip()

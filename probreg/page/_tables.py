"""Tables of a report: rows ready to be shown, the exact number beside what is printed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from probreg.page._units import SHOWN, Number, decimals, number, percent
from probreg.page._words import limit_text
from probreg.posterior.posterior import Posterior
from probreg.registration import Registration
from probreg.registration.residuals import Component
from probreg.typing import FloatArray

WORST = 20  # rows listed

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
            str(law.bad_rows),
        )
        for law in registration.laws
    ]
    columns = ("law", "elpd", "behind the best", "standard error", "rows, Pareto k > 0.7")
    caption = (
        f"Noise laws by leave-one-out (PSIS-LOO) on {registration.law_rows} rows, best first. The "
        "first one was used."
    )
    return Table("law-table", caption, columns, rows)


def noise(registration: Registration) -> Table | None:
    """Unknown parameters of the law chosen."""
    draws, first = registration.draws, len(registration.names)
    if len(draws.names) == first:
        return None
    interval = draws.interval(0.9)
    rows: list[tuple[Cell, ...]] = []
    for k in range(first, len(draws.names)):
        places = decimals(float(draws.sd[k]))
        cells = (draws.mean[k], draws.sd[k], *interval[k])
        rows.append((draws.names[k], *(number(float(value), places) for value in cells)))
    columns = ("parameter", "mean", "sd", "90 % from", "90 % to")
    caption = f"Parameters of the noise law {registration.laws[0].name}."
    return Table("noise-table", caption, columns, rows)


def suspects(registration: Registration, row_name: Callable[[int], str]) -> Table:
    """The rows most likely to hold an outlier or a wrong identity."""
    found = registration.suspects().head(WORST)
    labels = registration.recording.labels
    rows: list[tuple[Cell, ...]] = []
    for one in found.itertuples():
        label = labels[one.target] if one.target < len(labels) else str(one.target)
        where = ", ".join(
            f"{row_name(report)} ({sensor})"
            for report, sensor in zip(one.reports, one.sensors, strict=True)
        )
        rows.append((label, number(float(one.time), 3), percent(one.probability), where))
    columns = ("target", "time, s", "probability", "reports")
    caption = f"Rows that most likely hold a wrong report (at most {WORST}, the worst first)."
    return Table("suspect-table", caption, columns, rows)


def held_out(registration: Registration) -> Table | None:
    """Residuals of targets held out, before and after."""
    scored = registration.held_out
    if scored is None:
        return None
    rows: list[tuple[Cell, ...]] = []
    for kind, before, after, places in (
        ("m", scored.before_m, scored.after_m, 1),
        ("declared sd", scored.before_sd, scored.after_sd, 2),
    ):
        for what, share in (("median", 0.5), ("90 % of rows below", 0.9)):
            cells = (number(_quantile(v, share), places) for v in (before, after))
            rows.append((f"{what}, {kind}", *cells))
    scores = (scored.before_log_score, scored.after_log_score)
    rows.append(("mean log predictive density of a row", *(number(s, 2) for s in scores)))
    caption = (
        f"Residuals of {len(scored.rows)} rows of {scored.targets} targets held out: corrected "
        "with biases that the other targets gave."
    )
    return Table("held-out-table", caption, ("residual", "before", "after"), rows)


def _quantile(values: FloatArray, share: float) -> float:
    """Of the values that are there; rows with bearings are not in metres."""
    values = values[np.isfinite(values)]
    return float(np.quantile(values, share)) if values.size else float("nan")


def residuals(found: Sequence[Component]) -> Table:
    """Residuals of the reports of each sensor against the others."""
    rows: list[tuple[Cell, ...]] = []
    for one in found:
        shown = SHOWN[one.unit]
        before, after = one.spreads
        places = decimals(shown.factor * after.sd)
        values = (before.median, after.median, before.sd, after.sd)
        cells = (number(shown.factor * value, places) for value in values)
        rows.append((f"{one.sensor}: {one.name}", shown.symbol, str(len(one.rows)), *cells))
    columns = (
        "component",
        "unit",
        "reports",
        "median before",
        "median after",
        "spread before",
        "spread after",
    )
    caption = "Reports less the line between the other sensors' neighbouring reports."
    return Table("residual-table", caption, columns, rows)


def convergence(registration: Registration) -> Table:
    """R-hat and effective draws of every unknown."""
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


def priors(posterior: Posterior) -> Table:
    """What was believed before the data."""
    rows: list[tuple[Cell, ...]] = []
    prior = posterior.prior
    for k, name in enumerate(posterior.problem.names):
        shown = SHOWN[posterior.units[k]]
        sd = np.inf if prior is None else float(np.sqrt(prior.covariance[k, k]))
        rows.append((name, f"normal, 0 ± {shown.factor * sd:.4g} {shown.symbol}".rstrip()))
    for parameter in posterior.noise_prior:
        spread = f"median {parameter.median:g}, spread {parameter.spread:g}"
        rows.append((f"noise.{parameter.name}", spread))
    return Table("prior-table", "Priors.", ("unknown", "prior"), rows)

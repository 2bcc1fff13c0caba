"""The command `probreg`: register recordings, watch them, apply and compare results.

What computes is imported by the commands, so that help comes at once.
"""

from __future__ import annotations

import datetime
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

import probreg
from probreg.cli._comparing import check, history
from probreg.cli._options import (
    BiasesPath,
    NamesLaws,
    OutFile,
    OutFolder,
    Overwrite,
    Quiet,
    RecordingPath,
    Seed,
    SensorsPath,
    TrustUnits,
    flat,
)
from probreg.cli._terminal import EXIT_CODES, WARNINGS, end_on, plain_errors, progress
from probreg.cli._watching import EXIT_CODES as WATCH_CODES
from probreg.cli._watching import watch
from probreg.errors import InvalidInputError

if TYPE_CHECKING:
    from probreg.page import Provenance
    from probreg.recordings import Reading, Setup
    from probreg.registration import LawChoice, RankedTerms, Registration

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Sensor registration as probabilistic inference.",
    epilog=EXIT_CODES,
)


def main() -> None:
    """Run the command; an interrupt or a request to end leaves nothing behind."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end_on)
    app()


def _version(wanted: bool) -> None:
    if wanted:
        print(f"probreg {probreg.__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print it.")
    ] = False,
) -> None:
    """Sensor registration as probabilistic inference."""


class Request(NamedTuple):
    """What `register` is asked to do."""

    recording: RecordingPath
    sensors: SensorsPath
    out: OutFolder
    law: Annotated[
        list[str] | None,
        typer.Option(
            help="Noise law; may be repeated: of several the first that is as good as the best is "
            "used. Known: {known}. Default: {compared}, the simplest first."
        ),
    ] = None
    draws: Annotated[int, typer.Option(min=100, help="Posterior draws.")] = 2_000
    holdout: Annotated[float, typer.Option(help="Share of the targets held out for scoring.")] = 0.2
    compare: Annotated[
        bool, typer.Option("--compare", help="Try every further bias term there is.")
    ] = False
    seed: Seed = 0
    trust_units: TrustUnits = False
    overwrite: Overwrite = False
    quiet: Quiet = False

    def settings(self, laws: Sequence[LawChoice]) -> dict[str, Any]:
        """What the result depends on besides the files and the seed."""
        return {
            "law": ", ".join(choice.name for choice in laws),
            "draws": self.draws,
            "holdout": self.holdout,
            "compare": self.compare,
            "trust_units": self.trust_units,
        }


@app.command(epilog=EXIT_CODES, cls=NamesLaws)
@flat
def register(request: Request) -> None:
    """Estimate the biases of the sensors of a recording.

    Writes report.html, biases.csv, biases.json, tracks.parquet, reports.parquet, posterior.nc,
    the corrected recording and manifest.json into a folder, all of them or none.
    """
    with plain_errors():
        found = _register(request)
        alarms = _conclude(found, request.out, request.quiet)
    raise typer.Exit(WARNINGS if alarms else 0)


def _register(request: Request) -> Registration:
    started = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    recording, sensors, seed = request.recording, request.sensors, request.seed
    with progress(request.quiet, request.compare) as told:
        import numpy as np

        from probreg import page
        from probreg import registration as chain

        with page.result_folder(request.out, "register", overwrite=request.overwrite) as part:
            page.check_writable(part)
            rng = np.random.default_rng(seed)
            laws = _laws(request.law)
            options: dict[str, Any] = {"num_draws": request.draws, "holdout": request.holdout}
            source, setup = _read(recording, sensors, request.trust_units)
            told("read")
            reports = source.recording
            found = chain.register(reports, setup, rng=rng, laws=laws, on_step=told, **options)
            terms = _compared(found, rng) if request.compare else []
            told("terms")
            settings, files = request.settings(laws), (recording, sensors)
            provenance = _provenance(seed, settings, files, started, source)
            page.fill(found, part, source=source, provenance=provenance, terms=terms)
            told("report")
    return found


def _read(recording: Path, sensors: Path, trust_units: bool) -> tuple[Reading, Setup]:
    """A recording, and the setup under which its reports stand."""
    from probreg import recordings
    from probreg.recordings import setup_file

    source = recordings.read(recording, setup_file.read(sensors), trust_units=trust_units)
    return source, source.setup


def _provenance(
    seed: int, settings: dict[str, Any], files: tuple[Path, ...], started: str, source: Reading
) -> Provenance:
    from probreg.page import Provenance, checksum

    inputs = {path.name: checksum(path) for path in files}
    return Provenance("register", seed, settings, inputs, started, source.notes)


def _laws(names: list[str] | None) -> tuple[LawChoice, ...]:
    """The laws named, by default those that registration compares.

    Raises
    ------
    InvalidInputError
        A law that tracks cannot take.
    """
    import probreg.noise
    from probreg.discovery import public_classes
    from probreg.registration import LAWS, known_laws

    if not names:
        return LAWS
    known, every = known_laws(), public_classes(probreg.noise)
    for name in names:
        if name not in every:
            raise typer.BadParameter(f"no law {name!r}; known: {', '.join(known)}.")
        if name not in known:
            raise InvalidInputError(
                f"the law {name} is no sum of Gaussians over whole reports, which tracks need; "
                f"take one of {', '.join(known)}."
            )
    return tuple(known[name] for name in names)


def _compared(found: Registration, rng: Any) -> list[RankedTerms]:
    """The setup's bias model against those with one further term, or one bias more that drifts."""
    from probreg.registration import compare_setups, further_drifts, further_terms, with_biases

    terms = further_terms(found.setup).items()
    setups = {name: with_biases(found.setup, biases) for name, biases in terms}
    setups |= further_drifts(found.problem, found.fit)
    return compare_setups(found.recording, setups, rng=rng)


def _conclude(found: Registration, out: Path, quiet: bool) -> list[str]:
    """Print the biases, and what must be read before they are used."""
    from probreg.page import biases_text, matters

    alarms = matters(found)
    if not quiet:
        print(biases_text(found))
        print(f"results: {out / 'report.html'}")
        for text in alarms:
            print(f"warning: {text}", file=sys.stderr)
    return alarms


@app.command()
def correct(
    recording: RecordingPath,
    sensors: SensorsPath,
    biases: BiasesPath,
    out: OutFile,
    trust_units: TrustUnits = False,
) -> None:
    """Take known biases out of a recording, of the same sensors, without estimating anything."""
    with plain_errors():
        _change("correct", recording, sensors, biases, out, trust_units)


@app.command()
def restore(
    recording: RecordingPath,
    sensors: SensorsPath,
    biases: BiasesPath,
    out: OutFile,
    trust_units: TrustUnits = False,
) -> None:
    """Put the biases back into a corrected recording: the inverse of correct."""
    with plain_errors():
        _change("restore", recording, sensors, biases, out, trust_units)


def _change(
    name: str, recording: Path, sensors: Path, biases: Path, out: Path, trust_units: bool
) -> None:
    from probreg import recordings

    if out.exists():
        raise InvalidInputError(f"{out} is there already; name another file, or remove it.")
    source, setup = _read(recording, sensors, trust_units)
    theta = recordings.read_biases(biases, recordings.bias_model(setup).names)
    recordings.write_changed(out, source, setup, theta, getattr(recordings, name))


@app.command()
def simulate(
    out: OutFolder,
    reports: Annotated[int, typer.Option(min=100, help="Of all radars together.")] = 6_000,
    seed: Seed = 0,
    overwrite: Overwrite = False,
) -> None:
    """Write a simulated recording to try everything on: three radars, biases drawn at random.

    Writes reports.csv, sensors.toml and, beside them, truth.json.
    """
    with plain_errors():
        import dataclasses

        import numpy as np

        from probreg.page import result_folder, write_summary
        from probreg.scenarios.demonstration import SCENE, demonstration

        scene = dataclasses.replace(SCENE, reports=reports)
        with result_folder(out, "simulate", overwrite=overwrite) as part:
            demonstration(part, np.random.default_rng(seed), scene)
            write_summary(part, "simulate", {"seed": seed, "reports": reports})
        print(f"probreg register {out / 'reports.csv'} --sensors {out / 'sensors.toml'} --out ...")


app.command(epilog=WATCH_CODES)(watch)
app.command(epilog=EXIT_CODES)(check)
app.command(epilog=EXIT_CODES)(history)

"""Everything that a registration leaves in a folder."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from pathlib import Path

from probreg.page import _outputs
from probreg.page._folder import result_folder
from probreg.page._page import render
from probreg.page._provenance import Provenance, checksum
from probreg.recordings import Reading, correct, new_table, write_changed
from probreg.recordings.files import replacing
from probreg.registration import RankedTerms, Registration


def write_report(
    registration: Registration,
    path: str | Path,
    *,
    source: Reading | None = None,
    provenance: Provenance | None = None,
    terms: Sequence[RankedTerms] = (),
) -> None:
    """Write the page only.

    Parameters
    ----------
    registration : Registration
    path : str or Path
        Of the HTML file.
    source : Reading, optional
        The file that the recording came from: reports are then named by its rows.
    provenance : Provenance, optional
    terms : sequence of RankedTerms
        From `compare_terms`, shown in a section of their own.

    Raises
    ------
    InvalidInputError
        A path that cannot be written.
    """
    page = render(
        registration,
        _with_input(provenance or Provenance(), source),
        row_name=_report if source is None else source.row_name,
        terms=terms,
    )
    with replacing(path) as part:
        part.write_text(page, encoding="utf-8")


def write(
    registration: Registration,
    folder: str | Path,
    *,
    source: Reading | None = None,
    provenance: Provenance | None = None,
    terms: Sequence[RankedTerms] = (),
    overwrite: bool = False,
) -> None:
    """Write the page, biases, posterior, tracks, reports, corrected recording and a manifest.

    All or nothing: an error or an interrupt leaves the folder as it was.

    Parameters
    ----------
    registration, source, provenance, terms
        As for `write_report`. Without a source the corrected recording is a new CSV table.
    folder : str or Path
        Not there, empty, or with an earlier result.
    overwrite : bool
        Whether other files may be there.

    Raises
    ------
    InvalidInputError
        A folder with other files, or that cannot be written.
    """
    provenance = provenance or Provenance()
    with result_folder(folder, provenance.command, overwrite=overwrite) as part:
        fill(registration, part, source=source, provenance=provenance, terms=terms)


def fill(
    registration: Registration,
    folder: Path,
    *,
    source: Reading | None,
    provenance: Provenance,
    terms: Sequence[RankedTerms] = (),
) -> None:
    """Write every file into a folder that is there."""
    start = time.perf_counter()
    provenance = _with_input(provenance, source)
    write_report(
        registration, folder / "report.html", source=source, provenance=provenance, terms=terms
    )
    _outputs.write_csv(folder / "biases.csv", registration)
    _outputs.write_json(folder / "biases.json", registration, terms)
    _outputs.write_posterior(folder / _outputs.POSTERIOR, registration)
    _outputs.write_tables(folder, registration)
    if source is None:
        new_table.create(folder / "corrected.csv", registration.correct(), registration.setup)
    else:
        path = folder / f"corrected{source.changed_ending}"
        write_changed(path, source, registration.setup, registration.over_time, correct)
    seconds = time.perf_counter() - start
    _outputs.write_manifest(folder, registration, provenance, seconds)


def _with_input(provenance: Provenance, source: Reading | None) -> Provenance:
    """The provenance with the source's name, checksum and remarks, unless it has some."""
    if source is None or provenance.inputs:
        return provenance
    inputs = {source.path.name: checksum(source.path)}
    return dataclasses.replace(provenance, inputs=inputs, notes=source.notes)


def _report(number: int) -> str:
    return f"report {number}"

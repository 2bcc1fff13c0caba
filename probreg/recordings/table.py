"""Reports in a table, CSV or Parquet: one row a report, units in the names of the columns.

Columns: `time_s` or `time` (POSIX seconds or ISO 8601), `sensor`, and what the sensor reports:
`range_m`, `azimuth_deg`, `elevation_deg` of radars, `azimuth_deg` of bearing sensors, `east_m`,
`north_m`, `up_m` of position sensors. Position sensors may report in `latitude_deg`,
`longitude_deg` and `height_m` instead; a height may be missing. Optional: `target`,
`own_east_m`, `own_north_m`, `own_up_m` of a moving platform, `heading_deg` of it (compass).
Others stay as they are.

Heights of targets may stand in the rows of any sensor: `height_m` (above the ellipsoid, or above
the plane of a frame without an origin), and by pressure `pressure_altitude_m`, or `flight_level`
in hundreds of feet. Each becomes a report of its own, of a sensor of kind "height" or
"barometer", which is added to the setup where it has none.

Values stay as they are reported: slant ranges, azimuths from the sensor's own true north.
"""

from __future__ import annotations

from pathlib import Path

from probreg.recordings._recording import Recording
from probreg.recordings._rewriting import rewrite
from probreg.recordings._setup import Setup
from probreg.recordings._table import ROW_LIMIT
from probreg.recordings._table_reading import TableReading
from probreg.recordings.formats import choose, known_formats
from probreg.recordings.formats._table import TableFormat
from probreg.typing import IntArray


def table_format(path: Path) -> TableFormat:
    """The format of a table, by the ending of its name."""
    return choose(path, [form for form in known_formats() if isinstance(form, TableFormat)])


def read(
    path: str | Path, setup: Setup, *, row_limit: int = ROW_LIMIT, trust_units: bool = False
) -> TableReading:
    """Read a table of reports.

    The file is streamed; what it takes in memory is about 250 bytes a report.
    Rows may be in any order and are sorted by time. Times of day that fall back past midnight
    are refused: within one sensor, from below a day, by more than half a day.

    Parameters
    ----------
    path : str or Path
        Ends with .csv or .parquet.
    setup : Setup
    row_limit : int
        Longer files are refused.
    trust_units : bool
        Whether to leave out the checks for radians, kilometres and milliseconds by the look of
        the numbers.

    Returns
    -------
    TableReading

    Raises
    ------
    InvalidInputError
        With the line or column, and what to do.
    """
    path = Path(path)
    form = table_format(path)
    return form.read(path, setup, row_limit=row_limit, trust_units=trust_units)


def write(
    path: str | Path,
    recording: Recording,
    *,
    like: str | Path,
    setup: Setup,
    rows: IntArray | None = None,
) -> None:
    """Write a changed recording as a table of the same form as the one it was read from.

    Cells whose values did not change are written as they were, and so are all other columns
    and the order of rows. Nothing is left of a file that could not be completed.

    Parameters
    ----------
    path : str or Path
        With the same ending as `like`.
    recording : Recording
        Of as many reports as `like` has: changed in time and values.
    like : str or Path
        The table that was read.
    setup : Setup
        With which it was read.
    rows : ndarray of int, shape (n,), optional
        Row of the table that each report belongs to; those of `read` unless reports changed
        places.

    Raises
    ------
    InvalidInputError
        A table that cannot be read or does not belong to the recording, a path that cannot be
        written.
    """
    old = read(like, setup, row_limit=len(recording), trust_units=True)
    rewrite(old, path, recording, rows)

"""Files damaged at random are read or refused with an error of ours; nothing else comes out."""

from __future__ import annotations

import numpy as np
import pytest

from probreg.errors import InvalidInputError
from probreg.recordings import new_table, setup_file, table
from probreg.scenarios.demonstration import demonstration
from probreg.scenarios.traffic import TrafficScene

TYPED = np.frombuffer(b'0123456789,."-e[]{}=\n\r ', dtype=np.uint8)


def damaged(content, rng):
    """Cut off, change bytes, lose a stretch, repeat a stretch, type over."""
    data = bytearray(content)
    at = int(rng.integers(len(data)))
    how = rng.integers(5)
    if how == 0:
        del data[at:]
    elif how == 1:
        for place in rng.integers(len(data), size=3):
            data[place] = int(rng.integers(256))
    elif how == 2:
        del data[at : at + int(rng.integers(1, 60))]
    elif how == 3:
        data[at:at] = data[max(0, at - 40) : at]
    else:
        for place in rng.integers(len(data), size=2):
            data[place] = int(rng.choice(TYPED))
    return bytes(data)


@pytest.mark.parametrize("kind", ["csv", "parquet", "toml"])
def test_damage_is_refused_in_words(tmp_path, kind):
    scene = TrafficScene(reports=150)
    reports, sensors, _ = demonstration(tmp_path, np.random.default_rng(0), scene)
    setup = setup_file.read(sensors)
    new_table.create(tmp_path / "r.parquet", table.read(reports, setup).recording, setup)
    read, path = {
        "csv": (lambda p: table.read(p, setup), reports),
        "parquet": (lambda p: table.read(p, setup), tmp_path / "r.parquet"),
        "toml": (setup_file.read, sensors),
    }[kind]
    good, refused = path.read_bytes(), []
    rng = np.random.default_rng(5)
    for _ in range(100):
        path.write_bytes(damaged(good, rng))
        try:
            read(path)
        except InvalidInputError as error:
            refused.append(str(error))
    # damage to a digit or to an unused byte cannot be seen
    assert len(refused) > 50
    assert all(path.name in said for said in refused)

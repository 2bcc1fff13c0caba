"""Without the optional decoder the error says what to install."""

from __future__ import annotations

import sys

import pytest

from probreg.errors import MissingExtraError
from probreg.recordings.formats import asterix


def test_without_a_decoder_the_error_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "asterix", None)
    monkeypatch.delitem(sys.modules, "asterix.generated", raising=False)
    (tmp_path / "r.ast").write_bytes(b"\x30\x00\x03")
    with pytest.raises(MissingExtraError, match=r"probreg\[asterix\]"):
        asterix.survey(tmp_path / "r.ast")

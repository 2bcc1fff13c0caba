"""Write the locks: exact versions with the hashes of every file of them, for every platform.

`requirements.lock` is all that the project runs on. Torch as the package index has it for Linux
needs CUDA libraries, a CPU build does not: they are in `requirements-cuda.lock`, which `make`
installs where they are needed. Versions stay as they are while pyproject.toml allows them; to renew
one, take its lines out of the lock first.

Hashes of files that are not on the index (a CPU build of torch in a folder of PIP_FIND_LINKS) are
added, and kept while the version stays.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOCK, CUDA_LOCK = ROOT / "requirements.lock", ROOT / "requirements-cuda.lock"
CUDA = re.compile(r"(nvidia-|cuda-|triton==)")
HEADS = {
    LOCK: "# Everything the project runs on; `make lock` writes it. "
    "pip install --no-deps -r requirements.lock\n",
    CUDA_LOCK: "# What torch needs beyond requirements.lock where it is a CUDA build.\n",
}
OPTIONS = (
    *("--extra", "dev", "--universal", "--python-version", "3.11", "--generate-hashes"),
    *("--no-header", "--no-annotate", "--no-emit-index-url", "--quiet"),
)

Pins = dict[str, set[str]]


def parse(text: str) -> Pins:
    """Hashes by entry, `name==version` with its marker."""
    lines = text.replace("\\\n", "").splitlines()
    blocks = [line.split("--hash=") for line in lines if line and not line.startswith("#")]
    return {entry.strip(): {one.strip() for one in hashes} for entry, *hashes in blocks}


def resolve(former: str) -> Pins:
    """Pins that pyproject.toml asks for, on any platform, near the former ones."""
    with tempfile.TemporaryDirectory() as folder:
        tools, found = Path(folder) / "env", Path(folder) / "found.lock"
        venv.create(tools, with_pip=True)
        subprocess.run([tools / "bin" / "pip", "install", "--quiet", "uv"], check=True)
        found.write_text(former)
        command = [tools / "bin" / "uv", "pip", "compile", ROOT / "pyproject.toml", *OPTIONS]
        subprocess.run([*command, "--output-file", found], check=True, stdout=subprocess.DEVNULL)
        return parse(found.read_text())


def on_disk(entry: str) -> set[str]:
    """Hashes of the wheels of an entry in the folders where pip looks beside the index."""
    name, version = re.match(r"([^=]+)==([^ ;]+)", entry).groups()  # type: ignore[union-attr]
    stem = f"{name.replace('-', '_')}-{version}"
    folders = [Path(word) for word in os.environ.get("PIP_FIND_LINKS", "").split()]
    wheels = [path for folder in folders for path in folder.glob(f"{stem}[-+]*.whl")]
    return {f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}" for path in wheels}


def write(path: Path, pins: Pins) -> None:
    """One lock, in the form that pip reads."""
    bare = [entry for entry, hashes in pins.items() if not hashes]
    if bare:
        sys.exit(f"no hashes of {', '.join(bare)}")
    blocks = (
        " \\\n    ".join([entry, *(f"--hash={one}" for one in sorted(hashes))])
        for entry, hashes in sorted(pins.items())
    )
    path.write_text(HEADS[path] + "".join(f"{block}\n" for block in blocks))


def main() -> None:
    """Resolve, add what the index does not know, split."""
    former = "".join(path.read_text() for path in (LOCK, CUDA_LOCK) if path.exists())
    known = parse(former)
    pins = {
        entry: hashes | known.get(entry, set()) | on_disk(entry)
        for entry, hashes in resolve(former).items()
    }
    write(LOCK, {entry: hashes for entry, hashes in pins.items() if not CUDA.match(entry)})
    write(CUDA_LOCK, {entry: hashes for entry, hashes in pins.items() if CUDA.match(entry)})


if __name__ == "__main__":
    main()

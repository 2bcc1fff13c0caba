"""Install the wheel, with the newest dependencies, into an empty environment and register there.

For every interpreter found (PATH, pyenv), or those named: the wheel is built once, installed
without the lock, and the README's registration runs outside the repository.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MINORS = (11, 12, 13, 14)
DONE = (0, 3)  # 3: done, with warnings that matter
OUTPUTS = (
    *("report.html", "biases.csv", "biases.json", "posterior.nc", "corrected.csv"),
    "manifest.json",
)
# nothing of the repository, and no newer pip's opinion of itself
ENVIRONMENT = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}


def run(*command: str | Path, cwd: Path, codes: Sequence[int] = (0,)) -> str:
    """Run a command and give its output; its errors end the check."""
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True
    )
    if done.returncode not in codes:
        said = f"{done.stdout}{done.stderr}"
        raise SystemExit(f"{shlex.join(map(str, command))}: exit {done.returncode}\n{said}")
    return done.stdout + done.stderr


def candidates(minor: int) -> Iterator[Path]:
    """Where an interpreter may be: the folders of PATH, then pyenv's."""
    name = f"python3.{minor}"
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        yield Path(folder) / name
    if pyenv := shutil.which("pyenv"):
        root = subprocess.run([pyenv, "root"], capture_output=True, text=True).stdout.strip()
        yield from sorted(Path(root).glob(f"versions/3.{minor}.*/bin/{name}"), reverse=True)


def works(python: Path, minor: int) -> bool:
    """Whether an interpreter answers, as itself: a shim may be there without its version."""
    if not python.is_file():
        return False
    code = "import sys, venv, ensurepip; print(*sys.version_info[:2])"
    done = subprocess.run([python, "-c", code], capture_output=True, text=True)
    return done.stdout.split() == ["3", str(minor)]


def interpreters(after: int) -> list[Path]:
    """One interpreter of each minor version above `after`; says which are not found."""
    found = []
    for minor in (m for m in MINORS if m > after):
        python = next((path for path in candidates(minor) if works(path, minor)), None)
        if python is None:
            print(f"python3.{minor}: not found, skipped")
        else:
            found.append(python)
    return found


def readme_commands() -> list[list[str]]:
    """The README's first block that runs `probreg`."""
    blocks = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    lines = next(block for block in blocks if block.startswith("probreg ")).splitlines()
    return [shlex.split(line) for line in lines]


def check(python: Path, wheel: Path, work: Path) -> None:
    """Install and register in a folder of its own, which goes afterwards."""
    run(python, "-m", "venv", work / "env", cwd=work)
    scripts = work / "env" / "bin"
    run(scripts / "python", "-m", "pip", "install", "--quiet", "--upgrade", "pip", cwd=work)
    run(scripts / "python", "-m", "pip", "install", "--quiet", wheel, cwd=work)
    for name, *words in readme_commands():
        said = run(scripts / name, *words, cwd=work, codes=DONE)
        print("".join(f"  {line}\n" for line in said.splitlines() if "Warning" in line), end="")
    missing = [name for name in OUTPUTS if not (work / "demo" / "result" / name).is_file()]
    if missing:
        raise SystemExit(f"{python}: registration left no {', '.join(missing)}")
    size = run("du", "-sm", work / "env", cwd=work).split()[0]
    version = run(scripts / "python", "-V", cwd=work).strip()
    print(f"{version}: installed with the newest dependencies ({size} MB) and registered")


def main() -> None:
    """Check the interpreters named, or all that are found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pythons", nargs="*", type=Path, help="interpreters; default: all found")
    parser.add_argument(
        "--one-newer", action="store_true", help="only the newest above the one that runs this"
    )
    wanted = parser.parse_args()
    after = sys.version_info.minor if wanted.one_newer else MINORS[0] - 1
    pythons = [Path(shutil.which(p) or p) for p in wanted.pythons] or interpreters(after)
    if wanted.one_newer:
        pythons = pythons[-1:]
    if not pythons:
        print("no interpreter to check")
        return
    with tempfile.TemporaryDirectory() as folder:
        top = Path(folder)
        build = ("wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", top, ROOT)
        run(sys.executable, "-m", "pip", *build, cwd=top)
        (wheel,) = top.glob("probreg-*.whl")
        for number, python in enumerate(pythons):
            work = top / str(number)
            work.mkdir()
            check(python, wheel, work)
            shutil.rmtree(work)


if __name__ == "__main__":
    main()

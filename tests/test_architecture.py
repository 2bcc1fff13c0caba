"""The house stays a house: imports run downwards, and the package stays light."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import probreg
from probreg.discovery import public_classes
from probreg.sensors import kinds

PACKAGE = Path(probreg.__file__).parent
# lower rooms first; a module may import its own room and those before it
ROOMS = [
    *("errors", "extras", "typing", "discovery", "validation", "arviz_adapter"),
    *("numerics", "noise", "sensors", "recordings", "prior", "motion", "association", "scenarios"),
    *("problems", "posterior", "estimators", "samplers", "joint", "diagnostics"),
    *("registration", "watch", "page", "cli", "__main__"),
]
LEVEL = {name: level for level, name in enumerate(ROOMS)}
# rooms in which no function is long and none takes many arguments
LINES, ARGUMENTS = 50, 8


def modules():
    return [path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py"]


def room(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_run_downwards(path):
    own = room(path)
    assert own in LEVEL, f"{own} has no place in the house; give it one in ROOMS"
    for name in imported(path):
        parts = name.split(".")
        if parts[0] != "probreg" or len(parts) < 2 or parts[1] not in LEVEL:
            continue
        assert LEVEL[parts[1]] <= LEVEL[own], f"{own} imports {parts[1]}"


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_room_looks_into_the_private_modules_of_another(path):
    for name in imported(path):
        parts = name.split(".")
        if parts[0] == "probreg" and len(parts) > 2 and parts[1] != room(path):
            private = [part for part in parts[2:] if part.startswith("_")]
            assert not private, f"{room(path)} imports {name}: make it {parts[1]}'s public face"


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_computing_never_plots_and_studies_stay_outside(path):
    forbidden = {"experiments", "paper_figs", "tests"} | (
        set() if room(path) in {"page", "cli"} else {"matplotlib"}
    )
    assert not {name.split(".")[0] for name in imported(path)} & forbidden


def test_no_module_comes_back_to_itself():
    """Circles are found whatever the way of importing: at the top, in a function, for types."""
    names = {".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts): path
             for path in modules()}  # fmt: skip
    below = {name: {n for n in imported(path) if n in names} for name, path in names.items()}

    def reached(name, seen):
        for other in below[name] - seen:
            seen.add(other)
            reached(other, seen)
        return seen

    assert not [name for name in below if name in reached(name, set())]


def clumsy(source):
    """Functions of too many lines, docstring and all, or too many arguments beside self."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef):
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            arguments = [a.arg for a in given if a.arg not in ("self", "cls")]
            if node.end_lineno - node.lineno >= LINES or len(arguments) > ARGUMENTS:
                yield node.name


@pytest.mark.parametrize(
    "path",
    modules(),
    ids=lambda p: str(p.relative_to(PACKAGE)),
)
def test_functions_are_short_and_many_arguments_are_named_tuples(path):
    assert not list(clumsy(path.read_text()))


def test_a_long_function_and_one_of_many_arguments_are_found_out():
    body = "    x = 1\n" * LINES
    assert list(clumsy(f"def long():\n{body}")) == ["long"]
    assert list(clumsy(f"def fits():\n{body[: -len('    x = 1') - 1]}")) == []
    names = [f"a{k}" for k in range(ARGUMENTS + 1)]
    assert list(clumsy(f"def many({', '.join(names)}): ...")) == ["many"]
    assert list(clumsy(f"def method(self, {', '.join(names[1:])}): ...")) == []


def test_a_module_with_two_public_classes_is_found_out(tmp_path, monkeypatch):
    package = tmp_path / "crowded"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "pair.py").write_text("class One: ...\nclass Two: ...\n")
    monkeypatch.syspath_prepend(tmp_path)
    import crowded

    with pytest.raises(TypeError, match=r"must define one public class, not \['One', 'Two'\]"):
        public_classes(crowded)


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_global_random_state(path):
    text = path.read_text()
    for word in ("np.random.seed", "np.random.normal", "np.random.rand", "random.seed"):
        assert word not in text


KINDS = public_classes(kinds)
OF_SENSORS = {name for owner in KINDS.values() for name in dir(owner) if not name.startswith("_")}
OF_SENSORS |= {name for owner in KINDS.values() for name in owner.__dataclass_fields__}
OF_SENSORS -= {"name", "dim", "kind", "check"}  # others have these too


def asked_of_sensors(text):
    """Where code asks a sensor what it is, instead of the protocol: expressions, as text."""
    for node in ast.walk(ast.parse(text)):
        names = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        words = {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)}
        function = getattr(getattr(node, "func", None), "id", "")
        typed = isinstance(node, ast.Compare) or function in {"isinstance", "issubclass"}
        named = function in {"isinstance", "type", "getattr", "hasattr"} and "sensor" in names
        attribute = function in {"getattr", "hasattr"} and words & OF_SENSORS
        if named or attribute or (typed and names & KINDS.keys()):
            yield ast.unparse(node)


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_sensors_say_themselves_what_they_are(path):
    if room(path) != "sensors":
        assert list(asked_of_sensors(path.read_text())) == []


@pytest.mark.parametrize(
    "code",
    [
        "isinstance(sensor, BearingSensor)",
        "isinstance(one, Radar2D | Radar3D)",
        "any(type(s) is Tracker2D for s in sensors)",
        "type(sensor) in USED",
        "getattr(s, 'from_north', False)",
        "hasattr(self.sensors[0], 'to_cartesian')",
        "getattr(sensor, name)",
    ],
)
def test_a_question_to_a_sensor_is_found_out(code):
    assert list(asked_of_sensors(code))
    assert not list(asked_of_sensors("getattr(setup, key), isinstance(law, Contaminated)"))

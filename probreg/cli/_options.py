"""Options of a command as one NamedTuple, and help that is completed only when it is shown."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

import typer
from typer.core import TyperCommand

RecordingPath = Annotated[Path, typer.Argument(help="Reports: .csv, .parquet or .ast.")]
SensorsPath = Annotated[Path, typer.Option("--sensors", help="The file sensors.toml.")]
OutFolder = Annotated[Path, typer.Option("--out", help="Folder to write; made if not there.")]
OutFile = Annotated[Path, typer.Option("--out", help="File to write, with the input's ending.")]
BiasesPath = Annotated[Path, typer.Option("--biases", help="biases.json of a registration.")]
Seed = Annotated[int, typer.Option(min=0, help="Of the random numbers.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print errors only.")]
TrustUnits = Annotated[
    bool,
    typer.Option(
        "--trust-units", help="Do not refuse what looks like radians, kilometres or milliseconds."
    ),
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Write into a folder that holds other files.")
]

T = TypeVar("T", bound=tuple[Any, ...])


def flat(command: Callable[[T], None]) -> Callable[..., None]:
    """Make a command that takes the fields of a NamedTuple one by one, as the terminal gives them.

    Parameters
    ----------
    command : callable
        Its only parameter is annotated with the NamedTuple.
    """
    (kind,) = (hint for name, hint in get_type_hints(command).items() if name != "return")
    hints = get_type_hints(kind, include_extras=True)

    def run(**given: Any) -> None:
        command(kind(**given))

    run.__name__, run.__doc__, run.__annotations__ = command.__name__, command.__doc__, hints
    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=kind._field_defaults.get(name, inspect.Parameter.empty),
                annotation=hint,
            )
            for name, hint in hints.items()
        ]
    )
    return run


class NamesLaws(TyperCommand):
    """A command whose help names noise laws: `{known}` and, without --law, `{compared}`.

    They are looked up when help is asked for, so that nothing else waits for it.
    """

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, the names filled in."""
        from probreg.registration import LAWS, known_laws

        known, compared = ", ".join(known_laws()), ", ".join(choice.name for choice in LAWS)
        for option in self.params:
            text = getattr(option, "help", None) or ""
            option.help = text.format(known=known, compared=compared)  # type: ignore[attr-defined]
        super().format_help(ctx, formatter)

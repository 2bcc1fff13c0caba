"""Options of a command as one NamedTuple, and help that is completed only when it is shown."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, TypeVar, get_type_hints

from typer.core import TyperCommand

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

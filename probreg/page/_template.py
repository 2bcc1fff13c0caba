"""Templates of pages, filled in: one style, everything in the page's own text."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from typing import Any

import jinja2

from probreg.page._units import Number


def filled(name: str, content: Mapping[str, Any]) -> str:
    """A template with its content.

    Parameters
    ----------
    name : str
        Of a file beside this one.
    content : mapping
        Every variable that it names.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("probreg.page", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["number"] = lambda cell: isinstance(cell, Number)
    style = resources.files("probreg.page").joinpath("page.css").read_text(encoding="utf-8")
    return environment.get_template(name).render(style=style, **content)

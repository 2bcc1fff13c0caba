"""Finding the variants: one public class a module in `noise`, `estimators`, ..."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import ModuleType


def public_classes(package: ModuleType) -> dict[str, type]:
    """Classes of a package's public modules, by class name.

    Parameters
    ----------
    package : module
        A package such as `probreg.noise`.

    Returns
    -------
    dict of str to type

    Raises
    ------
    TypeError
        A module defines no public class, or more than one.
    """
    found = {}
    for entry in pkgutil.iter_modules(package.__path__):
        if entry.name.startswith("_") or entry.ispkg:
            continue
        module = importlib.import_module(f"{package.__name__}.{entry.name}")
        own = [
            member
            for name, member in inspect.getmembers(module, inspect.isclass)
            if member.__module__ == module.__name__ and not name.startswith("_")
        ]
        if len(own) != 1:
            names = [member.__name__ for member in own]
            raise TypeError(f"{module.__name__} must define one public class, not {names}.")
        found[own[0].__name__] = own[0]
    return found

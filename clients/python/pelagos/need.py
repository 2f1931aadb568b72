"""Packages that only some calls need, with a message that helps."""
from __future__ import annotations

from types import ModuleType

from .errors import MissingPackage


def numpy() -> ModuleType:
    try:
        import numpy as module
    except ImportError:
        raise MissingPackage(
            "arrays need NumPy: apt install python3-numpy, or "
            "pip install numpy") from None
    return module

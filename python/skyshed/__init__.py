"""Exact line-of-sight coverage maps: what a hovering UAV can see of a city.

>>> import skyshed
>>> city = skyshed.Scene.itu("urban", size=300)
>>> seen = city.map((150, 150, 120))
>>> seen.los.shape, seen.los.dtype.name
((300, 300), 'uint8')
>>> round(seen.p_los, 4)
0.6777

Options are those of the program, with ``_`` for ``-``: ``--rx-height 2`` is ``rx_height=2``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skyshed._answers import LOS, NLOS, NO_RECEIVER, NODATA, OUT_OF_RANGE, Answer, Coverage, Coverages, Link, LinkTable
    from skyshed._errors import Error, FileError, SkyshedWarning
    from skyshed._live import LivePage
    from skyshed._scene import Scene, info, plos

# What stands where; nothing is imported before it is used, so that the program starts at once.
_WHERE = {
    "Answer": "_answers",
    "Coverage": "_answers",
    "Coverages": "_answers",
    "Link": "_answers",
    "LinkTable": "_answers",
    "LOS": "_answers",
    "NLOS": "_answers",
    "NO_RECEIVER": "_answers",
    "OUT_OF_RANGE": "_answers",
    "NODATA": "_answers",
    "Error": "_errors",
    "FileError": "_errors",
    "SkyshedWarning": "_errors",
    "LivePage": "_live",
    "Scene": "_scene",
    "plos": "_scene",
    "info": "_scene",
}

__all__ = [
    "LOS",
    "NLOS",
    "NODATA",
    "NO_RECEIVER",
    "OUT_OF_RANGE",
    "Answer",
    "Coverage",
    "Coverages",
    "Error",
    "FileError",
    "Link",
    "LinkTable",
    "LivePage",
    "Scene",
    "SkyshedWarning",
    "info",
    "plos",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("skyshed")
    if name not in _WHERE:
        raise AttributeError(f"module 'skyshed' has no attribute {name!r}")
    from importlib import import_module

    value: object = getattr(import_module(f"skyshed.{_WHERE[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

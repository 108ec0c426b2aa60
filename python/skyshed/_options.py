"""Keywords of Python as the options of a request: one object of JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

if TYPE_CHECKING:
    from typing_extensions import TypeAlias

PathLike: TypeAlias = Union[str, "os.PathLike[str]"]


def plain(value: Any) -> Any:
    """Returns a value as JSON has it: numbers of numpy as numbers, paths as texts, several values as a list."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        # JSON has no word for these, and the reader of texts knows them.
        return float(value) if math.isfinite(value) else str(float(value))
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return plain(value.item())
    if isinstance(value, Iterable) and not isinstance(value, (bytes, Mapping)):
        return [plain(part) for part in value]
    raise TypeError(f"found {type(value).__name__}, wanted a number, a text or a path")


def plain_options(options: Mapping[str, object]) -> dict[str, Any]:
    """Returns options as JSON has them; ``None`` sets nothing.

    Raises a ``TypeError`` that names the option whose value cannot be.
    """
    found: dict[str, Any] = {}
    for name, value in options.items():
        if value is None:
            continue
        try:
            found[name] = plain(value)
        except TypeError as error:
            raise TypeError(f"{name}: {error}") from None
    return found


def as_json(options: Mapping[str, object]) -> str:
    """Returns options as the text of one object of JSON."""
    return json.dumps(plain_options(options))


def output_of(output: PathLike | Sequence[PathLike] | None) -> dict[str, list[str]]:
    """Returns the option that names output files; none without any."""
    if output is None:
        return {}
    files = [output] if isinstance(output, (str, os.PathLike)) else list(output)
    return {"output": [os.fspath(file) for file in files]} if files else {}


def watch_of(progress: object) -> Callable[[float], object] | None:
    """Who is told the share of the work that is done: a callable, or a bar of tqdm."""
    if progress is None:
        return None
    bar: Any = progress
    if hasattr(bar, "update") and hasattr(bar, "refresh"):
        bar.total = bar.total or 1.0

        def show(share: float) -> None:
            bar.n = round(share * bar.total, 3)
            bar.refresh()

        return show
    if callable(progress):
        return progress
    raise TypeError(f"progress: found {type(progress).__name__}, wanted a callable or a bar of tqdm")

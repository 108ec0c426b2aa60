"""Arguments of Python as words of the command line."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from skyshed._errors import wrong

if TYPE_CHECKING:
    from typing_extensions import TypeAlias

Height: TypeAlias = Union[float, str]
Uav: TypeAlias = Union[
    "tuple[float, float, Height]", "tuple[float, float, Height, str]", "Mapping[str, Any]", "np.ndarray[Any, Any]"
]
PathLike: TypeAlias = Union[str, "os.PathLike[str]"]
AskedUav = tuple[float, float, Union[float, str], Union[str, None]]


def word(value: object) -> str:
    """A value as it is typed."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"found {value!r}, wanted a number or a text")
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    raise TypeError(f"found {type(value).__name__}, wanted a number, a text or a path")


def words_of(options: Mapping[str, object]) -> list[str]:
    """Options as flags: ``None`` and ``False`` are not typed, several values stand behind commas."""
    words = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
            continue
        many = isinstance(value, (list, tuple, np.ndarray))
        try:
            said = ",".join(word(part) for part in value) if many else word(value)  # type: ignore[attr-defined]
        except TypeError as error:
            raise TypeError(f"{name}: {error}") from None
        words.append(f"{flag}={said}")
    return words


def files_of(output: PathLike | Sequence[PathLike] | None) -> list[str]:
    """Output files as flags."""
    if output is None:
        return []
    files = [output] if isinstance(output, (str, os.PathLike)) else list(output)
    return [f"--output={os.fspath(file)}" for file in files]


def _number(name: str, value: object) -> float:
    if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
        return float(value)
    raise TypeError(f"uav: found {value!r} as {name}, wanted a number")


def uav_of(uav: Uav) -> AskedUav:
    """A UAV as (x, y, height, name)."""
    name: object = None
    if isinstance(uav, Mapping):
        unknown = set(uav) - {"x", "y", "h", "id"}
        if unknown or not {"x", "y", "h"} <= set(uav):
            raise wrong("uav", f"the keys {sorted(map(str, uav))}", "x, y, h and, if you like, id", "E102")
        x, y, h, name = uav["x"], uav["y"], uav["h"], uav.get("id")
    elif isinstance(uav, (tuple, list, np.ndarray)) and len(uav) in (3, 4):
        x, y, h, *rest = uav
        name = rest[0] if rest else None
    else:
        raise wrong("uav", repr(uav)[:80], "(x, y, height), such as (500, 500, 120) or (500, 500, '30roof')", "E102")
    height = h if isinstance(h, str) else _number("height", h)
    x, y = _number("x", x), _number("y", y)
    for axis, value in (("x", x), ("y", y), ("height", height)):
        if isinstance(value, float) and not np.isfinite(value):
            raise wrong("uav", f"{value} as {axis}", "a number", "E102")
    return x, y, height, None if name is None else str(name)


def uavs_of(uavs: Iterable[Uav]) -> list[AskedUav]:
    """UAVs of a list, an array of shape (n, 3), or a table with columns x, y, h and, if you like, id; a table with a geometry
    of points needs h alone."""
    columns = getattr(uavs, "columns", None)
    if columns is not None:
        table: Any = uavs
        if "h" not in columns:
            raise wrong("uavs", f"the columns {list(columns)}", "a column h", "E102")
        points = table.geometry if hasattr(table, "geometry") and "x" not in columns else None
        xs, ys = (points.x, points.y) if points is not None else (table["x"], table["y"])
        ids = [str(name) for name in table["id"]] if "id" in columns else [None] * len(table)
        return [uav_of((x, y, h, name)) for x, y, h, name in zip(xs, ys, table["h"], ids)]  # type: ignore[arg-type]
    if isinstance(uavs, np.ndarray) and uavs.ndim != 2:
        raise wrong("uavs", f"an array of {uavs.ndim} dimensions", "(n, 3): x, y, height", "E102")
    if isinstance(uavs, (str, bytes, Mapping)):
        raise wrong("uavs", type(uavs).__name__, "several of (x, y, height)", "E102")
    return [uav_of(uav) for uav in uavs]


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


@contextmanager
def as_files(given: Mapping[str, object]) -> Iterator[dict[str, object]]:
    """Options that name files, with what is no path written to temporary ones: places as tables, geometries as GeoJSON."""
    with tempfile.TemporaryDirectory(prefix="skyshed-") as folder:
        named: dict[str, object] = {}
        for name, value in given.items():
            if value is None or isinstance(value, (str, os.PathLike)):
                named[name] = value
            elif hasattr(value, "__geo_interface__") or (isinstance(value, Mapping) and "type" in value):
                path = os.path.join(folder, f"{name}.geojson")
                with open(path, "w", encoding="utf-8") as file:
                    json.dump(_collection(getattr(value, "__geo_interface__", value)), file)
                named[name] = path
            else:
                path = os.path.join(folder, f"{name}.csv")
                with open(path, "w", encoding="utf-8") as file:
                    rows = uavs_of(value)  # type: ignore[arg-type]
                    has_ids = any(row[3] is not None for row in rows)
                    print("x,y,h,id" if has_ids else "x,y,h", file=file)
                    for x, y, h, id in rows:
                        end = "," + json.dumps(id or "") if has_ids else ""
                        print(f"{x!r},{y!r},{h}{end}", file=file)
                named[name] = path
        yield named


def _collection(geometry: Mapping[str, Any]) -> Mapping[str, Any]:
    """A geometry, a feature or several as a collection of features in the system of the scene."""
    if geometry.get("type") == "FeatureCollection":
        # Places in a scene are in its system, whatever GeoJSON would have them in.
        return {key: value for key, value in geometry.items() if key != "crs"}
    feature = geometry if geometry.get("type") == "Feature" else {"type": "Feature", "properties": {}, "geometry": geometry}
    return {"type": "FeatureCollection", "features": [feature]}

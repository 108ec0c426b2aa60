"""Arguments of Python as words of the command line."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
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
Pair = Union["tuple[float, float]", None]
#: From which distance [m], azimuths, elevations, the beam [deg].
AskedAntenna = tuple[Union[float, None], Pair, Pair, Union[float, None]]
AskedUav = tuple[float, float, Union[float, str], Union[str, None], AskedAntenna]

#: What says so in a mapping or a table of UAVs.
ANTENNA = ("min_radius", "sector", "elevation", "beam")


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
        if isinstance(value, (bool, np.bool_)) or value is None:
            words += [flag] if value else []
            continue
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value.item()
        many = isinstance(value, Iterable) and not isinstance(value, (str, bytes, Mapping))
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


def antenna_of(said: Mapping[str, object]) -> AskedAntenna:
    """An antenna of what is said of it; nothing, and what is no number in a table, is not limited."""

    def is_said(value: object) -> bool:
        is_empty = value is None or isinstance(value, str) and not value.strip()
        return not is_empty and not (isinstance(value, (float, np.floating)) and np.isnan(value))

    def one(name: str) -> float | None:
        value = said.get(name)
        return float(_number(name, value)) if is_said(value) else None

    def pair(name: str) -> tuple[float, float] | None:
        value = said.get(name)
        if not is_said(value):
            return None
        parts: Sequence[Any] = value.replace(";", ",").split(",") if isinstance(value, str) else list(value)  # type: ignore[call-overload]
        try:
            low, high = map(float, parts)
        except (TypeError, ValueError):
            raise wrong("uav", f"{value!r} as {name}", "two angles, such as (90, 180)", "E102") from None
        return low, high

    min_radius, sector, elevation, beam = ANTENNA
    return one(min_radius), pair(sector), pair(elevation), one(beam)


def uav_of(uav: Uav) -> AskedUav:
    """A UAV as (x, y, height, name, antenna)."""
    name: object = None
    antenna = antenna_of({})
    if isinstance(uav, Mapping):
        unknown = set(uav) - {"x", "y", "h", "id", *ANTENNA}
        if unknown or not {"x", "y", "h"} <= set(uav):
            wanted = f"x, y, h and, if you like, id, {', '.join(ANTENNA)}"
            raise wrong("uav", f"the keys {sorted(map(str, uav))}", wanted, "E102")
        x, y, h, name, antenna = uav["x"], uav["y"], uav["h"], uav.get("id"), antenna_of(uav)
    elif isinstance(uav, tuple) and len(uav) == 5 and isinstance(uav[4], tuple):
        x, y, h, name, antenna = uav
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
    return x, y, height, None if name is None else str(name), antenna


def table_of(uavs: Sequence[AskedUav]) -> list[Sequence[object]]:
    """UAVs as rows of a table that the program reads, its header first."""

    def said(pair: Pair) -> str:
        return "" if pair is None else f"{pair[0]!r},{pair[1]!r}"

    rows: list[Sequence[object]] = [("x", "y", "h", "id", *ANTENNA)]
    for x, y, h, id, (least, sector, elevation, beam) in uavs:
        rows.append((repr(x), repr(y), h, id, "" if least is None else least, said(sector), said(elevation), "" if beam is None else beam))
    return rows


def located(name: str, places: Any, crs: str | None) -> Any:
    """Places of geopandas in the reference system of a scene."""
    own = getattr(places, "crs", None)
    if own is None or not hasattr(places, "to_crs"):
        return places
    if crs is None:
        raise wrong(name, f"places in {own.name}, but the scene names no reference system", "places in that of the scene", "E206")
    return places.to_crs(crs)


def uavs_of(uavs: Any, crs: str | None = None, height: Height | None = None) -> list[AskedUav]:
    """UAVs of a list, an array of shape (n, 3), or a table with columns x, y, h and, if you like, id, min_radius, sector, elevation, beam.

    A table of geopandas has points instead of x and y, and is brought into the system ``crs``. What the package answers has
    height_agl_m or height_amsl_m instead of h. ``height`` is that of tables without one.
    """
    if isinstance(uavs, (str, bytes, Mapping)):
        raise wrong("uavs", type(uavs).__name__, "several of (x, y, height)", "E102")
    names = getattr(uavs, "columns", None) if getattr(uavs, "dtype", None) is None else uavs.dtype.names
    points = getattr(located("uavs", uavs, crs), "geometry", None)
    if names is None and points is None:
        if isinstance(uavs, np.ndarray) and uavs.ndim != 2:
            raise wrong("uavs", f"an array of {uavs.ndim} dimensions", "(n, 3): x, y, height", "E102")
        return [uav_of(uav) for uav in uavs]
    columns = list(names) if names is not None else []
    if points is not None:
        xs, ys = points.x, points.y
    elif {"x", "y"} <= set(columns):
        xs, ys = uavs["x"], uavs["y"]
    else:
        raise wrong("uavs", f"the columns {columns}", "columns x and y", "E102")
    heights: Iterable[Any]
    if "h" in columns:
        heights = uavs["h"]
    elif "height_agl_m" in columns:
        above = uavs["height_amsl_m"] if "height_amsl_m" in columns else uavs["height_agl_m"]
        heights = [agl if np.isfinite(agl) else f"{float(amsl)}amsl" for agl, amsl in zip(uavs["height_agl_m"], above)]
    elif height is not None:
        heights = [height] * len(uavs)
    else:
        raise wrong("uavs", f"the columns {columns}", "a column h", "E102")
    ids = [str(name) for name in uavs["id"]] if "id" in columns else [None] * len(uavs)
    rows = [uav_of(uav) for uav in zip(xs, ys, heights, ids)]  # type: ignore[arg-type]
    told = {name: list(uavs[name]) for name in ANTENNA if name in columns}
    antennas = [antenna_of({name: values[k] for name, values in told.items()}) for k in range(len(rows))]
    return [(*row[:4], antenna) for row, antenna in zip(rows, antennas)]


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


#: An option, the name of its input, and the bytes of that.
HeldInput = tuple[str, str, bytes]


def inputs_of(given: Mapping[str, Any], crs: str | None, height: Any) -> tuple[dict[str, object], list[HeldInput]]:
    """Options that name files, and what is no path as inputs in memory: candidates as a table, areas as GeoJSON."""
    named: dict[str, object] = {}
    held: list[HeldInput] = []
    for name, value in given.items():
        named[name] = value
        if value is None or isinstance(value, (str, os.PathLike)):
            continue
        if name == "candidates":
            # Heights of the search stand for those that places have not.
            text = _table_text(uavs_of(value, crs, None if height is None else 0.0))
        else:
            text = json.dumps(_collection(name, located(name, value, crs), crs))
        named[name] = f"{name}.csv" if name == "candidates" else f"{name}.geojson"
        held.append((name, str(named[name]), text.encode()))
    return named, held


def _table_text(rows: Sequence[AskedUav]) -> str:
    if not rows:
        raise wrong("candidates", "none", "at least one", "E209")
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(table_of(rows))
    return text.getvalue()


def _collection(name: str, area: Any, crs: str | None) -> Mapping[str, Any]:
    """A geometry, a feature, several, or a table of geopandas as a collection of features in the system of the scene."""
    area = getattr(area, "geometry", area) if hasattr(area, "to_crs") else area
    parts = area if isinstance(area, Iterable) and not isinstance(area, (Mapping, str, bytes)) else [area]
    features: list[Any] = []
    for part in parts:
        mapping = getattr(part, "__geo_interface__", part)
        if not isinstance(mapping, Mapping) or "type" not in mapping:
            raise wrong(name, repr(part)[:80], "a geometry, or several")
        if mapping["type"] == "FeatureCollection":
            features += mapping["features"]
        else:
            is_feature = mapping["type"] == "Feature"
            features.append(mapping if is_feature else {"type": "Feature", "properties": {}, "geometry": mapping})
    system = {"crs": {"type": "name", "properties": {"name": crs}}} if crs else {}
    return {"type": "FeatureCollection", **system, "features": features}

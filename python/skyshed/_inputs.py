"""UAVs, places and areas of Python as inputs of a request."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from skyshed._errors import wrong

if TYPE_CHECKING:
    from typing_extensions import TypeAlias

Height: TypeAlias = Union[float, str]
Uav: TypeAlias = Union[
    "tuple[float, float, Height]", "tuple[float, float, Height, str]", "Mapping[str, Any]", "np.ndarray[Any, Any]"
]
Pair = Union["tuple[float, float]", None]
#: From which distance [m], azimuths, elevations, the beam [deg], up to which distance in space [m].
AskedAntenna = tuple[Union[float, None], Pair, Pair, Union[float, None], Union[float, None]]
#: From when, to when.
AskedTime = tuple[Union[str, None], Union[str, None]]
AskedUav = tuple[float, float, Union[float, str], Union[str, None], AskedAntenna, AskedTime]

#: What says so in a mapping or a table of UAVs.
ANTENNA = ("min_radius", "sector", "elevation", "beam", "slant_range")


#: What says in a mapping or a table when a UAV is up.
TIMES = ("from", "to")


def time_of(said: Mapping[str, object]) -> AskedTime:
    """The time in which a UAV is up as texts: ISO 8601, or minutes; nothing, and what is no time in a table, is open."""

    def end(value: Any) -> str | None:
        # NaN and NaT differ from themselves.
        if value is None or value != value or isinstance(value, str) and not value.strip():
            return None
        if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
            return repr(float(value))
        if isinstance(value, np.datetime64):
            return str(value.astype("datetime64[us]"))
        return str(value.isoformat()) if hasattr(value, "isoformat") else str(value)

    return end(said.get("from")), end(said.get("to"))


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

    min_radius, sector, elevation, beam, slant_range = ANTENNA
    return one(min_radius), pair(sector), pair(elevation), one(beam), one(slant_range)


#: What is not said.
_ANY_ANTENNA, _ANY_TIME = antenna_of({}), time_of({})


def uav_of(uav: Uav) -> AskedUav:
    """A UAV as (x, y, height, name, antenna, time)."""
    name: object = None
    antenna, time = _ANY_ANTENNA, _ANY_TIME
    if isinstance(uav, tuple) and len(uav) in (3, 4):
        x, y, h, *rest = uav
        name = rest[0] if rest else None
    elif isinstance(uav, Mapping):
        uav = {"h" if name == "height" else name: value for name, value in uav.items()}
        unknown = set(uav) - {"x", "y", "h", "id", *ANTENNA, *TIMES}
        if unknown or not {"x", "y", "h"} <= set(uav):
            wanted = f"x, y, h and, if you like, id, {', '.join(ANTENNA + TIMES)}"
            raise wrong("uav", f"the keys {sorted(map(str, uav))}", wanted, "E102")
        x, y, h, name, antenna = uav["x"], uav["y"], uav["h"], uav.get("id"), antenna_of(uav)
        time = time_of(uav)
    elif isinstance(uav, tuple) and len(uav) == 6 and isinstance(uav[4], tuple):
        x, y, h, name, antenna, time = uav
    elif isinstance(uav, (list, np.ndarray)) and len(uav) in (3, 4):
        x, y, h, *rest = uav
        name = rest[0] if rest else None
    else:
        raise wrong("uav", repr(uav)[:80], "(x, y, height), such as (500, 500, 120) or (500, 500, '30roof')", "E102")
    height = h if isinstance(h, str) else _number("height", h)
    x, y = _number("x", x), _number("y", y)
    for axis, value in (("x", x), ("y", y), ("height", height)):
        if isinstance(value, float) and not math.isfinite(value):
            raise wrong("uav", f"{value} as {axis}", "a number", "E102")
    return x, y, height, None if name is None else str(name), antenna, time


def table_of(uavs: Sequence[AskedUav]) -> bytes:
    """UAVs as a table of CSV."""

    def said(pair: Pair) -> str:
        return "" if pair is None else f"{pair[0]!r},{pair[1]!r}"

    rows: list[Sequence[object]] = [("x", "y", "h", "id", *ANTENNA, *TIMES)]
    for x, y, h, id, (least, sector, elevation, beam, slant_range), times in uavs:
        numbers = ["" if number is None else number for number in (least, beam, slant_range)]
        rows.append((repr(x), repr(y), h, id, numbers[0], said(sector), said(elevation), *numbers[1:], *(time or "" for time in times)))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def located(name: str, places: Any, crs: str | None) -> Any:
    """Places of geopandas in the reference system of a scene."""
    own = getattr(places, "crs", None)
    if own is None or not hasattr(places, "to_crs"):
        return places
    if crs is None:
        raise wrong(name, f"places in {own.name}, but the scene names no reference system", "places in that of the scene", "E206")
    return places.to_crs(crs)


def is_one_uav(uavs: object) -> bool:
    """Whether it is one UAV where several are wanted, too."""
    return isinstance(uavs, Mapping) or isinstance(uavs, tuple) and len(uavs) in (3, 4) and isinstance(uavs[0], (int, float))


def uavs_of(uavs: Any, crs: str | None = None, height: Height | None = None) -> list[AskedUav]:
    """UAVs of a list, an array of shape (n, 3), or a table with columns x, y, h and, if you like, id, limits of an antenna (``ANTENNA``), and when it is up (``TIMES``).

    A table of geopandas has points instead of x and y, and is brought into the system ``crs``. What the package answers has
    height_agl_m or height_amsl_m instead of h. ``height`` is that of tables without one.
    """
    is_one = is_one_uav(uavs)
    if is_one or isinstance(uavs, (str, bytes)):
        raise wrong("uavs", "one UAV" if is_one else type(uavs).__name__, "several: [(x, y, height), …]", "E102")
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
    told = {name: list(uavs[name]) for name in ANTENNA + TIMES if name in columns}
    own = [{name: values[k] for name, values in told.items()} for k in range(len(rows))]
    return [(*row[:4], antenna_of(said), time_of(said)) for row, said in zip(rows, own)]


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
            listed = uavs_of(value, crs, None if height is None else 0.0)
            if not listed:
                raise wrong("candidates", "none", "at least one", "E209")
            held.append((name, "candidates.csv", table_of(listed)))
        else:
            text = json.dumps(_collection(name, located(name, value, crs), crs))
            held.append((name, f"{name}.geojson", text.encode()))
        named[name] = held[-1][1]
    return named, held


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


def track_of(track: Any) -> tuple[str, bytes | None]:
    """A track as a path, or as a name and a table in memory: a path, a line of shapely, or places in order."""
    # A line of shapely has its points apart, with heights above the datum.
    above = "amsl" if hasattr(track, "coords") else "agl"
    track = getattr(track, "coords", track)
    if isinstance(track, (str, os.PathLike)):
        return os.fspath(track), None
    places = np.asarray(track, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] not in (2, 3):
        raise wrong("track", f"an array of shape {places.shape}", "(n, 2): x, y, or (n, 3): x, y, height", "E103")
    rows = [",".join(map(repr, place)) + (above if len(place) == 3 else "") for place in places.tolist()]
    columns = "x,y" if places.shape[1] == 2 else "x,y,h"
    return "track.csv", "\n".join([columns, *rows, ""]).encode()

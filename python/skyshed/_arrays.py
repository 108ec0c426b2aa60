"""Heights in arrays: where their cells lie, what stands for no height, and in which order their bytes are."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from skyshed._errors import Error, wrong

Held = tuple[str, "np.ndarray[Any, Any]", tuple[float, float, float, float], "str | None", "float | None", bool]

#: Names of dimensions that run from west to east, and from north to south or back.
X_NAMES = ("x", "lon", "longitude", "easting")
Y_NAMES = ("y", "lat", "latitude", "northing")


class Transform(NamedTuple):
    """Where cells lie, in the order of ``affine.Affine``: x = a·column + b·row + c, y = d·column + e·row + f."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float


def transform_of(name: str, transform: Any) -> Transform:
    """A transform from an ``Affine`` or six numbers in its order."""
    try:
        numbers = [float(number) for number in transform][:9]
    except (TypeError, ValueError):
        raise wrong(name, repr(transform)[:80], "six numbers, as of rasterio") from None
    if len(numbers) not in (6, 9) or not all(np.isfinite(numbers)):
        raise wrong(name, repr(transform)[:80], "six numbers, as of rasterio")
    found = Transform(*numbers[:6])
    if found.a == 0 or found.e == 0 or found.b != 0 or found.d != 0:
        gdal = found.c == 0 and found.e == 0 and found.b > 0 and found.f < 0
        hint = "this is the order of GDAL: Affine.from_gdal(*transform)" if gdal else None
        raise Error(f"{name}: found {tuple(found)}, wanted a grid that is not rotated", "E113", hint)
    if found.a < 0:
        raise wrong(name, f"columns that run from east to west (a = {found.a})", "west to east: flip with array[:, ::-1]")
    if found.e > 0:
        raise wrong(name, f"rows that run from south to north (e = {found.e})", "north to south: flip with array[::-1]")
    return found


def crs_text(name: str, crs: Any) -> str | None:
    """A reference system as a text: EPSG:n where it has a code, else its WKT."""
    if crs is None:
        return None
    if isinstance(crs, (int, np.integer)) and not isinstance(crs, bool):
        return f"EPSG:{int(crs)}"
    if isinstance(crs, str):
        return crs
    epsg = getattr(crs, "to_epsg", lambda: None)()
    if epsg is not None:
        return f"EPSG:{epsg}"
    wkt = getattr(crs, "to_wkt", None)
    if wkt is not None:
        return str(wkt())
    raise TypeError(f"{name}: found {type(crs).__name__}, wanted EPSG:n, a WKT, or what pyproj or rasterio say")


def is_xarray(array: Any) -> bool:
    """Whether an array names its dimensions and coordinates."""
    return hasattr(array, "dims") and hasattr(array, "coords")


def plain(name: str, array: Any, nodata: Any) -> tuple[np.ndarray[Any, Any], float | None, bool]:
    """An array of two dimensions of real numbers in the order of bytes of the machine, what stands for no height in it, and
    whether its bytes are to be turned around; no copy unless its cells do not lie where the machine can read them."""
    if isinstance(array, np.ma.MaskedArray):
        kind = array.dtype if array.dtype.kind == "f" else np.dtype("f4" if array.dtype.itemsize <= 2 else "f8")
        array = np.ma.filled(array.astype(kind), np.nan)
    found = np.asarray(array)
    kind = found.dtype
    if found.ndim != 2:
        raise wrong(name, f"an array of shape {found.shape}", "two dimensions: rows and columns")
    if found.size == 0:
        raise wrong(name, f"an array of shape {found.shape}", "at least one cell")
    if found.dtype == np.float16:
        found = found.astype(np.float32)
    if found.dtype.kind not in "fiu" or found.dtype.itemsize > 8:
        raise TypeError(f"{name}: found an array of {found.dtype}, wanted real numbers of at most 64 bits")
    number = None
    if nodata is not None:
        try:
            number = float(np.asarray(nodata).astype(kind if kind.kind == "f" else float))
        except (TypeError, ValueError):
            raise wrong("nodata", repr(nodata)[:80], "a number") from None
        number = None if np.isnan(number) else number
    found = np.require(found, requirements=["ALIGNED"])
    is_swapped = not found.dtype.isnative
    if is_swapped:
        found = found.view(found.dtype.newbyteorder("="))
    return found, number, is_swapped


class Raster(NamedTuple):
    """An array that is placed."""

    array: Any
    transform: Transform
    crs: str | None
    nodata: Any


def placed(name: str, array: Any, transform: Any, crs: Any, nodata: Any) -> Raster:
    """An array with its place: of a DataArray its own, of any other what is said of it."""
    if is_xarray(array):
        return _of_xarray(name, array, transform, crs, nodata)
    if transform is None:
        raise wrong("transform", "none", f"one for {name}, which has no coordinates, such as (1, 0, west, 0, -1, north)")
    return Raster(array, transform_of("transform", transform), crs_text("crs", crs), nodata)


def held(name: str, raster: Raster, label: str) -> Held:
    """A raster as the extension takes it."""
    array, nodata, is_swapped = plain(name, raster.array, raster.nodata)
    a, _, c, _, e, f = raster.transform
    return label, array, (c, a, f, -e), raster.crs, nodata, is_swapped


def _of_xarray(name: str, array: Any, transform: Any, crs: Any, nodata: Any) -> Raster:
    for dim in list(array.dims):
        if array.ndim > 2 and array.sizes[dim] == 1:
            array = array.squeeze(dim, drop=True)
    dims = tuple(str(dim) for dim in array.dims)
    x_dim = next((dim for dim in dims if dim.lower() in X_NAMES), None)
    y_dim = next((dim for dim in dims if dim.lower() in Y_NAMES), None)
    if len(dims) != 2 or x_dim is None or y_dim is None:
        raise wrong(name, f"the dimensions {dims}", "y and x")
    array = array.transpose(y_dim, x_dim)
    for dim in (y_dim, x_dim):
        if dim not in array.coords and transform is None:
            raise wrong(name, f"no coordinates along {dim}", "those of the cells, or a transform")
    # Where rows run north and columns run west, they are turned around without a copy.
    if y_dim in array.coords and array.sizes[y_dim] > 1 and array[y_dim][0] < array[y_dim][-1]:
        array = array.isel({y_dim: slice(None, None, -1)})
    if x_dim in array.coords and array.sizes[x_dim] > 1 and array[x_dim][0] > array[x_dim][-1]:
        array = array.isel({x_dim: slice(None, None, -1)})
    scaling = (array.attrs.get("scale_factor", 1), array.attrs.get("add_offset", 0))
    if scaling != (1, 0):
        raise wrong(name, f"heights that are still to be scaled by {scaling}", "meters: open it with mask_and_scale=True")
    said: dict[str, Any] = next((array.coords[c].attrs for c in ("spatial_ref", "crs") if c in array.coords), {})
    if transform is not None:
        place = transform_of("transform", transform)
    else:
        place = _of_coordinates(name, (array[x_dim].values, array[y_dim].values), said.get("GeoTransform"))
    if crs is None:
        crs = said.get("crs_wkt") or said.get("spatial_ref") or array.attrs.get("crs")
    if crs is None and (x_dim.lower() in ("lon", "longitude") or y_dim.lower() in ("lat", "latitude")):
        degrees = f"coordinates in degrees by their names ({y_dim}, {x_dim})"
        hint = '`crs="EPSG:4326", project="auto"` brings them to meters; if they are meters, name their system with `crs`'
        raise Error(f"{name}: found {degrees}, wanted meters", "E310", hint)
    if nodata is None:
        keys = ("_FillValue", "missing_value", "nodata", "nodatavals")
        found = [said.get(key) for said in (array.attrs, array.encoding) for key in keys]
        nodata = next((np.ravel(value)[0] for value in found if value is not None and np.size(value)), None)
    return Raster(array.values, place, crs_text("crs", crs), nodata)


def _of_coordinates(name: str, centers: tuple[Any, Any], said: Any) -> Transform:
    """The transform of the centers of cells; the one that is said where it is that, for it is not rounded."""
    known = None
    if said is not None:
        c, a, b, f, d, e = (float(number) for number in str(said).split())
        known = Transform(a, b, c, d, e, f)
    steps = []
    for axis, values in zip("xy", centers):
        values = np.asarray(values, dtype=float)
        if values.size > 1:
            step = (values[-1] - values[0]) / (values.size - 1)
            even = values[0] + step * np.arange(values.size)
            if step == 0 or not np.all(np.abs(values - even) <= 1e-3 * abs(step)):
                raise wrong(name, f"uneven coordinates along {axis}", "cells of one size")
        elif known is not None:
            step = known.a if axis == "x" else known.e
        else:
            raise wrong(name, f"one cell along {axis}", "a transform, which says how large it is")
        steps.append(float(step))
    (xs, ys), (width, height) = centers, steps
    found = Transform(width, 0.0, float(xs[0]) - width / 2, 0.0, height, float(ys[0]) - height / 2)
    if known is not None and np.allclose(known, found, rtol=0, atol=1e-6 * width):
        found = known
    return transform_of(name, found)

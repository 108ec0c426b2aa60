"""DataArrays in and out, and GeoTIFFs that rasterio reads as those of the program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import towns

from skyshed import LOS, Error, Scene

xarray = pytest.importorskip("xarray")
pytest.importorskip("skyshed.xarray")
pytestmark = pytest.mark.filterwarnings("ignore::skyshed.SkyshedWarning")


def dsm(heights: np.ndarray[Any, Any]) -> Any:
    n_rows, n_cols = heights.shape
    ys = 5000 - 2 * (np.arange(n_rows) + 0.5)
    xs = 1000 + 2 * (np.arange(n_cols) + 0.5)
    return xarray.DataArray(heights, dims=("y", "x"), coords={"y": ys, "x": xs}, name="dsm")


def test_arrays_are_placed_by_their_coordinates() -> None:
    heights = towns(2)
    array = dsm(heights)
    wanted = Scene.from_raster(heights, transform=(2, 0, 1000, 0, -2, 5000)).map((1040, 4960, 60.0)).digest
    turned = array.isel(y=slice(None, None, -1))
    for given in [array, turned, array.transpose("x", "y"), array.expand_dims("band"), array.rename(x="easting", y="northing"), array.assign_attrs(_FillValue=-1.5e9)]:
        scene = Scene.from_raster(given)
        assert scene.map((1040, 4960, 60.0)).digest == wanted, given.dims


def test_what_is_no_grid_is_refused() -> None:
    array = dsm(towns(2))
    uneven = array.isel(x=[0, 1, 3, 4])
    for bad, name in [
        (array.rename(x="time"), "dimensions"),
        (array.drop_vars("x"), "coordinates along x"),
        (uneven, "uneven coordinates along x"),
        (array.isel(y=[0]), "one cell along y"),
        (array.expand_dims(band=2), "dimensions"),
        (array.rename(x="lon", y="lat"), "degrees"),
        (array.assign_attrs(scale_factor=0.1), "scaled"),
    ]:
        with pytest.raises(Error, match=name):
            Scene.from_raster(bad)


def test_a_terrain_has_a_place_of_its_own() -> None:
    def grid(first: int, n: int, cell: float = 1.0) -> Any:
        centers = first + cell * (np.arange(n) + 0.5)
        heights = 5 * np.sin(centers / 9) * np.cos(centers[::-1, None] / 11)
        return xarray.DataArray(heights, dims=("y", "x"), coords={"y": centers[::-1], "x": centers})

    surface = grid(0, 100)
    surface[40:60, 40:60] += 20
    wanted = Scene.from_raster(surface, terrain=grid(0, 100)).map((20, 50, 30.0))
    wide = Scene.from_raster(surface, terrain=grid(-20, 140)).map((20, 50, 30.0))
    assert wide.receivers == wanted.receivers and wide.p_los == pytest.approx(wanted.p_los, abs=0.01)
    coarse = Scene.from_raster(surface, terrain=grid(0, 50, 2.0)).map((20, 50, 30.0))
    assert coarse.receivers > 0.9 * wanted.receivers
    holed = grid(0, 100)
    holed[:30] = -9999
    marked = surface.assign_attrs(_FillValue=-1)
    of_marked = Scene.from_raster(marked, terrain=holed.assign_attrs(_FillValue=-9999)).map((20, 40, 30.0))
    assert of_marked.document["sites"][0]["receivers"] <= wanted.receivers and int((of_marked.los == 255).sum()) == 3000
    with pytest.raises(Error, match="EPSG:32633"):
        Scene.from_raster(surface.assign_attrs(crs="EPSG:25832"), terrain=grid(0, 100).assign_attrs(crs="EPSG:32633"))


def test_the_accessor_has_the_words_of_xarray_spatial() -> None:
    array = dsm(towns(2))
    for given in [array, array.isel(y=slice(None, None, -1)), array.rename(x="easting", y="northing")]:
        y, x = given.dims
        seen = given.skyshed.viewshed(x=1041, y=4961, observer_elev=30, target_elev=1)
        assert seen.dims == given.dims and seen.shape == given.shape and seen.name == "viewshed"
        xarray.testing.assert_equal(seen[x].drop_vars("spatial_ref", errors="ignore"), given[x])
        xarray.testing.assert_equal(seen[y].drop_vars("spatial_ref", errors="ignore"), given[y])
        scene = Scene.from_raster(given)
        wanted = scene.map((1041, 4961, 30.0), rx_height=1).los
        found = seen if seen[y].values[0] > seen[y].values[-1] else seen.isel({y: slice(None, None, -1)})
        assert np.array_equal(found.values, wanted)
    for given in [array, array.isel(y=slice(None, None, -1))]:
        near = given.skyshed.viewshed(x=1041, y=4961, observer_elev=30, max_distance=20)
        whole = given.skyshed.viewshed(x=1041, y=4961, observer_elev=30)
        assert bool(((near == LOS) == (whole == LOS)).where(near != 3, True).all())
        # On the very coordinates, so that they can be joined.
        assert int(given.where(near == LOS).notnull().sum()) == int((near == LOS).sum()) > 0


def test_through_rioxarray_and_back(tmp_path: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    rioxarray = pytest.importorskip("rioxarray")
    with rasterio.open(
        tmp_path / "dsm.tif", "w", driver="GTiff", width=50, height=40, count=1, dtype="float32", crs="EPSG:25832", nodata=-9999,
        transform=rasterio.Affine(2, 0, 691000.25, 0, -2, 5335000.75),
    ) as file:  # fmt: skip
        file.write(np.nan_to_num(towns(3), nan=-9999).astype("f4"), 1)
    uav = (691050.0, 5334950.0, 60.0)
    by_file = Scene.open(tmp_path / "dsm.tif").map(uav)
    by_file.save(tmp_path / "ours.tif")
    for masked in (True, False):
        array = rioxarray.open_rasterio(tmp_path / "dsm.tif", masked=masked)
        seen = Scene.from_raster(array).map(uav)
        assert seen.digest == by_file.digest
        path = tmp_path / f"theirs_{masked}.tif"
        seen.to_xarray()["los"].rio.to_raster(path)
        with rasterio.open(tmp_path / "ours.tif") as ours, rasterio.open(path) as theirs:
            assert theirs.transform == ours.transform and theirs.crs == ours.crs and theirs.nodata == ours.nodata
            assert np.array_equal(theirs.read(1), ours.read(1))
        part = array.isel(x=slice(7, 40), y=slice(3, 30))
        west, _, _, north = Scene.from_raster(part).bounds
        assert (west, north) == (691000.25 + 14, 5335000.75 - 6)


def test_flags_follow_the_conventions() -> None:
    found = Scene.from_raster(dsm(towns(2))).map((1040, 4960, 60.0), layers=["los", "margin", "ceiling"]).to_xarray()
    assert found.los.attrs["flag_meanings"].split() == ["nlos", "los", "no_receiver", "out_of_range", "nodata"]
    assert list(found.los.attrs["flag_values"]) == [0, 1, 2, 3, 255]
    seen, margin = found.los.values == LOS, found.margin.values
    assert np.array_equal(margin >= 0, seen) and found.ceiling.attrs["units"] == "m"

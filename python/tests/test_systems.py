"""Reference systems and bands, as Python gives them."""

from __future__ import annotations

import math
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

import skyshed
from skyshed import Scene

#: Cells of 2 units at Oslo, where these are half a meter.
OSLO = (2, 0, 1196600, 0, -2, 8379820)
TRUE_M = 1 / math.cosh(8379760 / 6378137)


def test_an_array_in_web_mercator_has_lengths_on_the_ground() -> None:
    with pytest.warns(skyshed.SkyshedWarning, match="W331"):
        scene = Scene.from_raster(np.zeros((60, 60)), transform=OSLO, crs="EPSG:3857", ground=0)
    link = scene.link((1196670, 8379761, 50), (1196610, 8379761, 1.5))
    assert math.isclose(link["distance_m"], 60 * TRUE_M, rel_tol=1e-3)
    with pytest.warns(skyshed.SkyshedWarning) as told:
        moved = Scene.from_raster(np.zeros((60, 60)), transform=OSLO, crs="EPSG:3857", ground=0, project="auto")
    assert moved.crs == "EPSG:32632"
    assert not any("W331" in str(warning.message) for warning in told)


def test_footprints_in_web_mercator_are_refused() -> None:
    x, y = 1196700, 8379700
    house = {"type": "Polygon", "coordinates": [[[x, y], [x + 40, y], [x + 40, y + 80], [x, y + 80], [x, y]]]}
    with pytest.raises(skyshed.Error) as raised:
        Scene.from_footprints([house], [20], crs="EPSG:3857")
    assert raised.value.code == "E310" and 'project="auto"' in (raised.value.hint or "")
    with pytest.warns(skyshed.SkyshedWarning, match="W335"):
        Scene.from_footprints([house], [20], crs="EPSG:3857", project="auto")


def test_a_band_is_named_by_number_or_name(tmp_path: Path) -> None:
    for name, height in [("low", 1), ("high", 9)]:
        rows = (" ".join([str(height)] * 4) + "\n") * 4
        (tmp_path / f"{name}.asc").write_text(f"ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n{rows}")
    band = (
        '<VRTRasterBand dataType="Float32" band="{}"><Description>{}</Description><SimpleSource><SourceFilename '
        'relativeToVRT="1">{}.asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>'
    )
    bands = band.format(1, "share", "low") + band.format(2, "top", "high")
    vrt = tmp_path / "two.vrt"
    place = "<SRS>EPSG:25832</SRS><GeoTransform>0, 1, 0, 4, 0, -1</GeoTransform>"
    vrt.write_text(f'<VRTDataset rasterXSize="4" rasterYSize="4">{place}{bands}</VRTDataset>')
    # On ground of 1 m the first band is flat, and the second one roof.
    for chosen, receivers in [(1, 16), (2, 0), ("share", 16), ("top", 0)]:
        with pytest.warns(skyshed.SkyshedWarning) if receivers == 0 else nullcontext():
            assert Scene.open(vrt, band=chosen, ground=1).map((2, 2, 50)).receivers == receivers
    with pytest.raises(skyshed.Error, match="top") as raised:
        Scene.open(vrt, band="roof", ground=0)
    assert raised.value.code == "E108"
    with pytest.warns(skyshed.SkyshedWarning, match="W323"):
        Scene.open(vrt, ground=0)

"""``import skyshed.xarray`` gives every DataArray of heights a viewshed.

>>> import numpy as np, xarray, skyshed.xarray
>>> dsm = xarray.DataArray(np.zeros((50, 60)), dims=("y", "x"), coords={"y": np.arange(50)[::-1] + 0.5, "x": np.arange(60) + 0.5})
>>> seen = dsm.skyshed.viewshed(x=30, y=25, observer_elev=2)
>>> int(seen.sum())
3000
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray

from skyshed._answers import OUT_OF_RANGE
from skyshed._errors import Error, tell
from skyshed._scene import Scene

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from skyshed.keywords import SceneKeywords


#: How rioxarray brings heights in degrees to meters.
_IN_METERS = "bring the heights to meters first: `array.rio.reproject(array.rio.estimate_utm_crs())` of rioxarray"


@xarray.register_dataarray_accessor("skyshed")  # type: ignore[no-untyped-call]
class SkyshedAccessor:
    """Questions about a DataArray of heights above the datum [m]."""

    def __init__(self, array: xarray.DataArray) -> None:
        self._array = array

    def scene(self, **options: Unpack[SceneKeywords]) -> Scene:
        """The scene of these heights: see :meth:`skyshed.Scene.from_raster`."""
        name = str(self._array.name or "array")
        scene = Scene._of_raster(self._array, (None, options.pop("crs", None), None), (options.pop("terrain", None), None, None), name, options)
        # A surface alone is what a viewshed is of.
        tell([told for told in scene._scene.warnings if told[0] != "W342"])
        return scene

    def viewshed(
        self,
        x: float,
        y: float,
        observer_elev: float = 0,
        target_elev: float = 0,
        max_distance: float | None = None,
        name: str = "viewshed",
        **options: Any,
    ) -> xarray.DataArray:
        """Which cells an observer sees, in the words of xarray-spatial: ``observer_elev`` above the surface below (x, y),
        ``target_elev`` above that of each cell, within ``max_distance`` [m].

        The answer has the dimensions and coordinates of these heights, and classes: 1 seen, 0 not, 2 no receiver, 3 out of range,
        255 no data. Unlike there, the observer stands at (x, y) itself, and cells are decided exactly, at their centers.
        """
        if options.get("project") is not None:
            raise Error("project: the answer lies on the cells of these heights", "E116", _IN_METERS)
        try:
            scene = self.scene(**options)
        except Error as error:
            if error.code == "E310" and "degrees" in error.text:
                raise type(error)(error.text, error.code, _IN_METERS) from None
            raise
        seen = scene.map((float(x), float(y), float(observer_elev)), rx_height=target_elev, radius=max_distance)
        # Of a part in range, the rest of the cells is out of range.
        row = round((scene.bounds[3] - seen.bounds[3]) / -scene.transform.e)
        col = round((seen.bounds[0] - scene.bounds[0]) / scene.transform.a)
        cells = np.full(scene.shape, OUT_OF_RANGE, dtype=np.uint8)
        cells[row : row + seen.shape[0], col : col + seen.shape[1]] = seen.los
        y_dim, x_dim = self._dims()
        of_mask = seen.to_xarray()["los"].attrs
        coords = {"y": ("y", scene.ys()), "x": ("x", scene.xs()), "spatial_ref": scene.coordinates()["spatial_ref"]}
        found = xarray.DataArray(cells, dims=("y", "x"), coords=coords, name=name, attrs=of_mask).rename({"y": y_dim, "x": x_dim})
        # In the order of rows of the heights, and on their very coordinates.
        found = found.isel({dim: slice(None, None, -1) for dim in (y_dim, x_dim) if self._is_turned(dim, found)})
        found = found.assign_coords({dim: self._array[dim] for dim in (y_dim, x_dim) if dim in self._array.coords})
        return found.transpose(*(dim for dim in self._array.dims if dim in (y_dim, x_dim)))

    def _dims(self) -> tuple[str, str]:
        from skyshed._arrays import X_NAMES, Y_NAMES

        dims = [str(dim) for dim in self._array.dims]
        return next(d for d in dims if d.lower() in Y_NAMES), next(d for d in dims if d.lower() in X_NAMES)

    def _is_turned(self, dim: str, found: xarray.DataArray) -> bool:
        own = self._array[dim].values
        return len(own) > 1 and bool((own[0] < own[-1]) != (found[dim].values[0] < found[dim].values[-1]))

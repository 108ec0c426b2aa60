"""Answers: coverage of one and of several UAVs, links, tables."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from skyshed._arrays import Transform
from skyshed._errors import wrong
from skyshed._options import PathLike, as_json, watch_of

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas
    import xarray
    from typing_extensions import Unpack

    from skyshed.keywords import SaveKeywords
    from skyshed._skyshed import Found, Maps, _Link, _Place

#: Classes of a mask.
NLOS, LOS, NO_RECEIVER, OUT_OF_RANGE, NODATA = 0, 1, 2, 3, 255

#: Layers that hold numbers, and their names in the extension.
MEASURES = {
    "margin": "margin",
    "ceiling": "least-receiver-height",
    "least-receiver-height": "least-receiver-height",
    "least-height": "least-height",
    "stability": "stability",
    "sure": "sure",
    "p-los": "p-los",
    "p_los": "p-los",
}


class Picture(NamedTuple):
    """A picture in PNG; a notebook shows it."""

    png: bytes

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        return f"Picture({len(self.png)} bytes)"


class Grid:
    """Where cells lie."""

    def __init__(self, place: _Place) -> None:
        self.shape, (self._west, self._width, self._north, self._height), self._crs = place

    @property
    def transform(self) -> Transform:
        """In the order of ``affine.Affine``, as rasterio takes it."""
        return Transform(self._width, 0.0, self._west, 0.0, -self._height, self._north)

    @property
    def crs(self) -> str | None:
        """The reference system: EPSG:n, else its WKT; ``None`` for local meters."""
        if self._crs is None:
            return None
        label, wkt = self._crs
        return label if label.startswith("EPSG:") else wkt or label

    @property
    def wkt(self) -> str | None:
        """The reference system as WKT."""
        return self._crs[1] if self._crs else None

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """West, south, east, north."""
        n_rows, n_cols = self.shape
        return self._west, self._north - self._height * n_rows, self._west + self._width * n_cols, self._north

    def xs(self) -> npt.NDArray[np.float64]:
        """East of the centers of columns."""
        return np.asarray(self._west + self._width * (np.arange(self.shape[1]) + 0.5), dtype=np.float64)

    def ys(self) -> npt.NDArray[np.float64]:
        """North of the centers of rows, from north to south."""
        return np.asarray(self._north - self._height * (np.arange(self.shape[0]) + 0.5), dtype=np.float64)

    def coordinates(self) -> dict[str, Any]:
        """As coordinates of xarray, readable by rioxarray."""
        a, b, c, d, e, f = self.transform
        of_grid = {"GeoTransform": " ".join(repr(float(number)) for number in (c, a, b, f, d, e))}
        if self.wkt:
            of_grid |= {"crs_wkt": self.wkt, "spatial_ref": self.wkt}
        unit = {"units": "m"}
        x = ("x", self.xs(), {"standard_name": "projection_x_coordinate", "axis": "X", **unit})
        y = ("y", self.ys(), {"standard_name": "projection_y_coordinate", "axis": "Y", **unit})
        return {"y": y, "x": x, "spatial_ref": ((), 0, of_grid)}


class _Mapped(Grid):
    """What coverage of one and of several have in common."""

    def __init__(self, maps: Maps) -> None:
        super().__init__(maps.place)
        self._maps = maps

    @property
    def digest(self) -> str:
        """SHA-256 of the masks: equal for equal answers, whatever the machine and the number of threads."""
        return self._maps.digest

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document ``skyshed/map/1``, as of ``skyshed map --json``."""
        found: dict[str, Any] = json.loads(self._maps.document())
        return found

    def save(self, *paths: PathLike, **options: Unpack[SaveKeywords]) -> None:
        """Writes files by their extensions: pictures (.png .svg .pdf), rasters (.tif .exr .asc .bil .npz), tables (.csv), documents
        (.json), features (.geojson .fgb), overlays (.kmz).

        ``options`` are those of ``skyshed map``: ``overwrite``, ``bare``, ``tif_layout``, ``gdal_values``, ``polygons``,
        ``simplify``, ``title``, ``attribution``, ``width``, ``dpi``, ``csv_text``.
        """
        self._maps.save([os.fspath(path) for path in paths], as_json(options))

    def picture(self, **options: Unpack[SaveKeywords]) -> Picture:
        """The picture of the program, as a notebook shows it; options are those of :meth:`save`."""
        return Picture(self._maps.picture(as_json(options)))

    def _repr_png_(self) -> bytes:
        return self.picture().png

    def height_curve(
        self, heights: tuple[float, float, float] | None = None, *, progress: object = None
    ) -> Answer:
        """P_LoS against the height of each UAV above the ground below it, exact.

        ``heights`` are from, to and step [m], by default some 150 round ones.
        """
        try:
            asked = None if heights is None else [float(height) for height in heights]
        except (TypeError, ValueError):
            raise wrong("heights", repr(heights), "three numbers: from, to and step [m]") from None
        if asked is not None and len(asked) != 3:
            raise wrong("heights", repr(heights), "from, to and step [m]")
        return Answer(self._maps.height_curves(asked, watch_of(progress)))


#: Attributes of a number of UAVs.
COUNT = {"long_name": "UAVs in line of sight", "units": "1"}


def flags() -> dict[str, Any]:
    """Attributes of a mask by the CF conventions."""
    flags = np.array([NLOS, LOS, NO_RECEIVER, OUT_OF_RANGE, NODATA], dtype=np.uint8)
    meanings = "nlos los no_receiver out_of_range nodata"
    return {"flag_values": flags, "flag_meanings": meanings, "long_name": "line of sight", "_FillValue": np.uint8(NODATA)}


class Coverage(_Mapped):
    """What one UAV sees."""

    @property
    def los(self) -> npt.NDArray[np.uint8]:
        """The class of each cell: 0 no line of sight, 1 line of sight, 2 no receiver, 3 out of range, 255 no data. Rows run from
        north to south. The array is the map's own memory and cannot be written."""
        return self._maps.mask(0)

    @property
    def p_los(self) -> float:
        """The share of receivers in range that are in line of sight; NaN without any, and of a UAV over no data: ``reason`` says which."""
        return self._maps.p_los()[0]

    @property
    def reason(self) -> str | None:
        """Why there is no P_LoS."""
        reason: str | None = self.document["sites"][0].get("reason")
        return reason

    @property
    def p_los_interval(self) -> tuple[float, float] | None:
        """Between which shares P_LoS is in 95 % of maps with heights redrawn, if the map was made with ``height_error`` or ``height_bias``."""
        uncertain = self.document["sites"][0].get("uncertain", {})
        return (uncertain["p_los_low"], uncertain["p_los_high"]) if "p_los_low" in uncertain else None

    @property
    def receivers(self) -> int:
        """Receivers in range."""
        return self._maps.receivers()[0]

    @property
    def zones(self) -> dict[str, dict[str, Any]] | None:
        """Counts by zone (street, crossroad, courtyard, rooftop), if the map was made with ``zones=True``."""
        zones: dict[str, dict[str, Any]] | None = self.document["sites"][0]["zones"]
        return zones

    def layer(self, name: str) -> npt.NDArray[np.float32]:
        """A layer that was asked for, NaN where there is no receiver: heights [m] of ``margin``, ``ceiling`` and
        ``least-height``, or ``stability``, ``sure`` (0 never, 1 surely, 2 possibly in line of sight) and ``p-los`` (probabilities)."""
        found = self._maps.layer(0, MEASURES.get(name, name))
        if found is None:
            raise KeyError(f"layer {name!r}: it was not asked for, or holds no heights")
        return found

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self.los if name == "los" else self.layer(name)

    def to_xarray(self) -> xarray.Dataset:
        """All layers with their coordinates; ``.los.rio.to_raster("los.tif")`` writes one."""
        import xarray

        layers: dict[str, Any] = {"los": (("y", "x"), self.los, flags() | {"grid_mapping": "spatial_ref"})}
        for name in ("margin", "ceiling", "least-height", "stability", "sure", "p-los"):
            found = self._maps.layer(0, MEASURES[name])
            if found is not None:
                unit = {"units": "m" if name in ("margin", "ceiling", "least-height") else "1"}
                layers[name.replace("-", "_")] = (("y", "x"), found, unit | {"grid_mapping": "spatial_ref"})
        attrs = {"digest": self.digest, "p_los": self.p_los, "source": "skyshed"}
        return xarray.Dataset(layers, self.coordinates(), attrs)

    def plot(self, ax: Any = None) -> Any:
        """The picture of the program, or the map drawn on axes of matplotlib."""
        if ax is None:
            return self.picture()
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        # Those of the program's pictures.
        colors = ["#e69f00", "#0072b2", "#c3c6c9", "#e9edf0", "#ffffff"]
        classes = np.searchsorted([NLOS, LOS, NO_RECEIVER, OUT_OF_RANGE, NODATA], self.los)
        west, south, east, north = self.bounds
        ax.imshow(
            classes, cmap=ListedColormap(colors), vmin=0, vmax=4, extent=(west, east, south, north), interpolation="nearest"
        )
        shown = [(1, "Line of sight"), (0, "No line of sight"), (2, "No receiver")]
        patches = [Patch(facecolor=colors[k], label=label) for k, label in shown if np.any(classes == k)]
        if patches:
            ax.legend(handles=patches, loc="upper right", fontsize="small")
        site = self.document["sites"][0]
        ax.plot([site["x"]], [site["y"]], marker="^", color="black", markeredgecolor="white", markersize=9)
        ax.set_title(f"P_LoS {self.p_los:.4f}")
        ax.ticklabel_format(useOffset=False, style="plain")
        return ax

    def __repr__(self) -> str:
        n_rows, n_cols = self.shape
        return f"Coverage(p_los={self.p_los:.4f}, receivers={self.receivers}, cells={n_rows}×{n_cols})"


class Mapper(Protocol):
    """A scene that is mapped once more."""

    @property
    def maps(self) -> Any:
        """Maps several."""


class Coverages(_Mapped):
    """What several UAVs see, each and together. Iterating makes one map after another, each on the cells in range of its own UAV,
    and keeps none. A UAV that was left out has no map; its numbers are NaN, and ``reasons`` says why."""

    def __init__(self, maps: Maps, scene: Mapper, uavs: list[Any], asked: dict[str, Any], is_kept: bool) -> None:
        super().__init__(maps)
        self._scene, self._uavs, self._asked, self._is_kept = scene, uavs, asked, is_kept
        #: Names of UAVs that cannot be at their place and were left out (``bad_uavs="skip"``), and why.
        self.reasons = dict(maps.left_out)

    def __len__(self) -> int:
        return len(self._uavs)

    def __iter__(self) -> Iterator[Coverage]:
        for uav, name in zip(self._uavs, self.ids):
            if name not in self.reasons:
                yield Coverage(self._scene.maps([uav], keep=True, **self._asked)._maps)

    @property
    def ids(self) -> list[str]:
        """The names of the UAVs; those without one are numbered from 1."""
        return [name or str(k + 1) for k, (*_, name, _, _) in enumerate(self._uavs)]

    @property
    def receivers(self) -> npt.NDArray[np.int64]:
        """Receivers in range of each UAV; 0 of one that was left out."""
        return np.nan_to_num(self._of_each(self._maps.receivers())).astype(np.int64)

    @property
    def p_los(self) -> npt.NDArray[np.float64]:
        """The share of receivers in range that each UAV sees; NaN without any, of a UAV over no data, and of one that was left out."""
        return self._of_each(self._maps.p_los())

    def _of_each(self, numbers: Sequence[float]) -> npt.NDArray[np.float64]:
        """Numbers of the UAVs with a map, in the places of all."""
        known = iter(numbers)
        return np.array([np.nan if name in self.reasons else next(known) for name in self.ids], dtype=np.float64)

    @property
    def union_p_los(self) -> float:
        """The share of receivers in range of any UAV that at least one sees; NaN without any, and where a UAV is over no data."""
        return self._maps.union_p_los()

    @property
    def union(self) -> npt.NDArray[np.uint8]:
        """The class of each cell for all together: line of sight if any UAV sees it."""
        return self._maps.union()

    @property
    def count(self) -> npt.NDArray[np.uint32]:
        """How many UAVs see each cell."""
        return self._maps.count()

    def layer(self, name: str) -> npt.NDArray[Any]:
        """A layer of all UAVs together that ``layers`` asked for: ``all``, ``best-server``, ``uptime`` (share of time in which a UAV that
        is up sees a cell) or ``gap`` (longest time in which none does [min])."""
        try:
            return self._maps.together(name)
        except IndexError:
            raise wrong("layer", repr(name), "one of all UAVs together that layers asked for") from None

    @cached_property
    def which(self) -> npt.NDArray[np.uint64]:
        """Which UAVs see each cell: bit k is set if UAV k does, of at most 64."""
        if len(self) > 64:
            raise ValueError(f"which: found {len(self)} UAVs, wanted at most 64")
        bits = np.zeros(self.shape, dtype=np.uint64)
        # All on the cells of all: those of one alone may be fewer.
        maps = self._maps if self._is_kept else self._scene.maps(self._uavs, keep=True, **self._asked)._maps
        mapped = (k for k, name in enumerate(self.ids) if name not in self.reasons)
        for site, k in enumerate(mapped):
            bits |= (maps.mask(site) == LOS).astype(np.uint64) << np.uint64(k)
        return bits

    def to_xarray(self) -> xarray.Dataset:
        """``union`` and ``count`` with their coordinates."""
        import xarray

        of_grid = {"grid_mapping": "spatial_ref"}
        layers = {
            "union": (("y", "x"), self.union, flags() | of_grid),
            "count": (("y", "x"), self.count, COUNT | of_grid),
        }
        attrs = {"digest": self.digest, "p_los": self.union_p_los, "source": "skyshed"}
        return xarray.Dataset(layers, self.coordinates(), attrs)

    def __repr__(self) -> str:
        return f"Coverages({len(self)} UAVs, union_p_los={self.union_p_los:.4f})"


#: Parts that every document has.
HEAD = ("schema", "version", "command", "request", "method", "scene", "timing", "warnings")


class Answer:
    """An answer as a document, and as a table where it has one."""

    def __init__(self, found: Found) -> None:
        self._found = found

    @cached_property
    def document(self) -> dict[str, Any]:
        """What the program prints with ``--json``."""
        found: dict[str, Any] = json.loads(self._found.document)
        return found

    def __getitem__(self, name: str) -> Any:
        if name not in self.document:
            raise KeyError(f"no part {name!r}, there are: {', '.join(self.document)}")
        return self.document[name]

    def keys(self) -> list[str]:
        """The parts of the document."""
        return list(self.document)

    @property
    def files(self) -> list[str]:
        """Files that were written."""
        return [os.fspath(path) for path in self._found.files]

    @cached_property
    def table(self) -> npt.NDArray[np.void]:
        """The table as a structured array: numbers are numbers, and NaN where there is none."""
        header, *rows = self._found.table or [[]]
        columns = [_column(name, [row[k] for row in rows]) for k, name in enumerate(header)]
        kinds = [(name, column.dtype) for name, column in zip(header, columns)]
        table = np.empty(len(rows), dtype=kinds)
        for name, column in zip(header, columns):
            table[name] = column
        return table

    def to_dataframe(self) -> pandas.DataFrame:
        """The table as a DataFrame."""
        import pandas

        return pandas.DataFrame({name: self.table[name] for name in self.table.dtype.names or ()})

    def _repr_html_(self) -> str:
        from html import escape

        header, *rows = self._found.table or [[]]

        def row(cells: list[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        shown = "".join(row(cells, "td") for cells in rows[:50])
        more = f"<p>{len(rows) - 50} more rows</p>" if len(rows) > 50 else ""
        return f"<table>{row(header, 'th')}{shown}</table>{more}"

    def __repr__(self) -> str:
        parts = ", ".join(name for name in self.document if name not in HEAD)
        return f"{type(self).__name__}({self.document.get('schema')}, {max(len(self._found.table) - 1, 0)} rows; {parts})"


class Link(Answer):
    """One link: whether it is in line of sight, by how much, and what stands in the way.

    The document is made when it is asked for.
    """

    def __init__(self, link: _Link, ask: Callable[[], Found]) -> None:
        self._link, self._ask = link, ask

    @cached_property
    def _found(self) -> Found:  # type: ignore[override]
        return self._ask()

    @property
    def los(self) -> bool:
        """Whether the link is in line of sight."""
        return self._link[0]

    @property
    def margin(self) -> float | None:
        """Height of the receiver less the least height in line of sight [m]; ``None`` if no height is enough."""
        return self._link[1]

    @property
    def distance(self) -> float:
        """Horizontal distance [m]."""
        return self._link[2]

    @property
    def elevation(self) -> float:
        """Elevation angle of the UAV from the receiver [deg]."""
        return self._link[3]

    @property
    def obstruction(self) -> dict[str, Any] | None:
        """What stands in the way; ``None`` in line of sight."""
        found = self._link[4]
        if found is None:
            return None
        kind, *place, x, y, ray, roof = found
        named = {name: value for name, value in zip(("id", "row", "col"), place) if value is not None}
        return {"kind": kind, **named, "x": x, "y": y, "ray_height_m": ray, "roof_height_m": roof}

    def __bool__(self) -> bool:
        return self.los


class LinkTable:
    """Links between UAVs and receivers, as arrays of shape (UAVs, receivers), and of pairs (pairs,).

    A UAV or a receiver that cannot be at its place has no answer: ``uav_faults`` and ``rx_faults`` say why.
    """

    def __init__(self, arrays: dict[str, npt.NDArray[Any]], uav_faults: dict[int, str], rx_faults: dict[int, str]) -> None:
        self._arrays = arrays
        #: Why UAVs cannot be at their place, by their places in the list.
        self.uav_faults = uav_faults
        #: Why receivers cannot be at their place, by their places in the list.
        self.rx_faults = rx_faults

    @property
    def los(self) -> npt.NDArray[np.uint8]:
        """1 in line of sight, 0 without, 255 without an answer."""
        return self._arrays["los"]

    @property
    def p_los(self) -> float:
        """The share of links with an answer that are in line of sight; NaN without any."""
        known = self.los[self.los != 255]
        return float(np.mean(known == 1)) if known.size else float("nan")

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """One of :meth:`keys`; NaN without an answer."""
        if name not in self._arrays:
            raise KeyError(f"no array {name!r}, there are: {', '.join(self._arrays)}")
        return self._arrays[name]

    def keys(self) -> list[str]:
        """``los``, ``margin_m``, ``distance_m``, ``slant_m``, ``azimuth_deg`` and ``elevation_deg`` of the UAV from the receiver,
        ``obstacle_x``, ``obstacle_y``, and the places ``uavs`` and ``receivers``: x, y, height above the datum [m]. With ``los_only``
        ``los`` and the places."""
        return list(self._arrays)

    def __len__(self) -> int:
        return int(self.los.size)

    def __repr__(self) -> str:
        return f"LinkTable({' × '.join(map(str, self.los.shape))} links, p_los={self.p_los:.4f})"


def _column(name: str, cells: list[str]) -> npt.NDArray[Any]:
    """Cells of a table as numbers where all are, else as text, as names are."""
    if name in ("id", "site"):
        return np.array(cells, dtype=np.str_)
    try:
        return np.array([int(cell) for cell in cells], dtype=np.int64)
    except (ValueError, OverflowError):
        pass
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return np.array(cells, dtype=np.str_)

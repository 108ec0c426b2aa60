"""Scenes, and what they are asked."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

import numpy as np

from skyshed import _skyshed
from skyshed._answers import Answer, Coverage, Coverages, Grid, Link, LinkTable
from skyshed._arrays import Held, crs_text, held, is_xarray, placed
from skyshed._errors import Error, tell, wrong
from skyshed._inputs import HeldInput, Uav, inputs_of, is_one_uav, table_of, track_of, uav_of, uavs_of
from skyshed._live import LivePage
from skyshed._options import PathLike, as_json, output_of, plain_options, watch_of
from skyshed.keywords import (
    AnySceneKeywords,
    CityKeywords,
    CompareKeywords,
    FootprintKeywords,
    InfoKeywords,
    LimitsKeywords,
    LinkKeywords,
    MapKeywords,
    PlaceKeywords,
    PlosKeywords,
    SampleKeywords,
    SceneKeywords,
    SightKeywords,
    TrackKeywords,
    ZonesKeywords,
)

if sys.version_info >= (3, 11):
    from typing import Self, Unpack
elif TYPE_CHECKING:
    from typing_extensions import Self, Unpack

if TYPE_CHECKING:
    import numpy.typing as npt

    from skyshed._skyshed import Found, _Link


#: Names of the options that say how a scene is read.
READING = frozenset(SceneKeywords.__optional_keys__)

_Kind = TypeVar("_Kind", bound=Answer)


class Origin(NamedTuple):
    """What a scene of files or a generated city is opened by, wherever a process is."""

    word: str
    options: dict[str, Any]


class Scene(Grid):
    """A city ready for rays: footprints, a surface model, a mesh or a generated city, over a grid of cells.

    Scenes do not change, may be asked by several threads at once, and can be pickled.
    """

    def __init__(self, scene: _skyshed.Scene, word: str, reading: dict[str, Any], origin: Origin | None = None) -> None:
        super().__init__(scene.place)
        self._scene, self._word, self._reading, self._origin = scene, word, reading, origin

    @classmethod
    def open(
        cls, path: PathLike | Sequence[PathLike], *, progress: object = None, **options: Unpack[SceneKeywords]
    ) -> Self:
        """Opens any file that the program reads: a raster, footprints, a point cloud or a mesh, packed or not; a folder or a list
        of files of one format is one scene.

        ``cell`` is the size of the cells of footprints [m], ``extent`` = (west, south, east, north) keeps that part alone; ``terrain``,
        ``data_area``, ``missing``, ``roofs``, ``project`` and more: ``help(skyshed.keywords.SceneKeywords)``.

        >>> munich = Scene.open("maps/munich.geojson")
        >>> munich.shape
        (1111, 1406)
        """
        reading, word = _reading(options), "+".join(os.fspath(each) for each in _listed(path))
        origin = origin_of(path, options)
        scene = cls(_skyshed.Scene.open(word, as_json(reading), watch_of(progress)), word, reading, origin)
        tell(scene._scene.warnings)
        return scene

    @classmethod
    def itu(cls, kind: str, *, size: float = 1000, seed: int = 1, **options: Unpack[AnySceneKeywords]) -> Self:
        """A generated city of the ITU-R P.1410 model: ``suburban``, ``urban``, ``dense-urban``, ``high-rise``, or
        ``"alpha,beta,gamma"``; ``size`` is its edge [m].

        >>> Scene.itu("urban", size=200).shape
        (200, 200)
        """
        reading = _reading({**options, "size": size, "seed": seed})
        word = kind if kind.startswith("itu:") else f"itu:{kind}"
        return cls(_skyshed.Scene.open(word, as_json(reading)), word, reading, Origin(word, reading))

    @classmethod
    def from_raster(
        cls,
        surface: Any,
        *,
        transform: Any = None,
        crs: Any = None,
        nodata: Any = None,
        terrain: Any = None,
        terrain_transform: Any = None,
        terrain_nodata: Any = None,
        name: str = "array",
        **options: Unpack[AnySceneKeywords],
    ) -> Self:
        """A scene of a surface model in memory, heights in meters: an array with a transform, or a DataArray, which has its own.

        ``transform`` is that of rasterio: ``Affine`` or (cell width, 0, west, 0, -cell height, north). ``terrain`` is what lies
        below: an array on the cells of the surface or with ``terrain_transform``, a DataArray, or a path. Without it, and without
        ``ground``, receivers stand on the surface.

        >>> import numpy as np
        >>> heights = np.zeros((100, 100))
        >>> heights[40:60, 40:60] = 20
        >>> block = Scene.from_raster(heights, transform=(1, 0, 0, 0, -1, 100), ground=0)
        >>> block.map((20, 50, 30)).receivers
        9600
        """
        made = cls._of_raster(surface, (transform, crs, nodata), (terrain, terrain_transform, terrain_nodata), name, options)
        tell(made._scene.warnings)
        return made

    @classmethod
    def _of_raster(
        cls,
        surface: Any,
        place: tuple[Any, Any, Any],
        below_it: tuple[Any, Any, Any],
        name: str,
        options: Mapping[str, object],
    ) -> Self:
        """A scene of heights; what is odd is not told yet."""
        (transform, crs, nodata), (terrain, terrain_transform, terrain_nodata) = place, below_it
        above = placed("surface", surface, transform, crs, nodata)
        below: Held | None = None
        if terrain is not None and not isinstance(terrain, (str, os.PathLike)):
            # An array lies as the surface does where nothing is said, a DataArray where it says itself.
            if terrain_transform is None and not is_xarray(terrain):
                terrain_transform = above.transform
            lower = placed("terrain", terrain, terrain_transform, crs, terrain_nodata)
            below = held("terrain", lower if lower.crs else lower._replace(crs=above.crs), f"terrain of {name}")
            terrain = None
        reading = _reading({**options, "terrain": terrain})
        return cls(_skyshed.Scene.of_heights(held("surface", above, name), below, as_json(reading)), name, reading)

    @classmethod
    def from_footprints(
        cls,
        buildings: Any,
        heights: Any = "height",
        *,
        crs: Any = None,
        ids: Iterable[object] | None = None,
        name: str = "buildings",
        **options: Unpack[FootprintKeywords],
    ) -> Self:
        """A scene of buildings in memory: a GeoDataFrame and the name of its column of heights, or geometries and their heights
        above the ground [m].

        Geometries are those of shapely, well-known binary, or mappings as of GeoJSON; several may also be given as one pair
        ``(geometries, heights)``. NaN is a height that is missing (``missing`` says what to do).
        """
        if isinstance(buildings, tuple) and len(buildings) == 2 and isinstance(heights, str):
            buildings, heights = buildings
        geometry = getattr(buildings, "geometry", None)
        if geometry is not None and hasattr(geometry, "to_wkb"):
            crs = crs if crs is not None else buildings.crs
            if isinstance(heights, str):
                if heights not in buildings:
                    raise wrong("heights", f"no column {heights!r} among {list(buildings)}", "the name of a column", "E365")
                heights = buildings[heights]
            geometries: list[Any] = list(geometry.to_wkb())
        else:
            geometries = list(buildings)
        if isinstance(heights, str):
            raise wrong("heights", repr(heights), "a height for each building, for they have no columns")
        if hasattr(heights, "reindex") and hasattr(buildings, "index"):
            heights = heights.reindex(buildings.index)
        try:
            column = np.ascontiguousarray(heights, dtype=np.float64)
        except (TypeError, ValueError):
            raise wrong("heights", repr(heights)[:80], "a number for each building") from None
        if column.shape != (len(geometries),):
            raise wrong("heights", f"an array of shape {column.shape}", f"one for each of {len(geometries)} buildings")
        wkb = [_wkb(k, shape) for k, shape in enumerate(geometries)]
        names = None if ids is None else [str(id) for id in ids]
        if names is not None and len(names) != len(wkb):
            raise wrong("ids", f"{len(names)} names", f"one for each of {len(wkb)} buildings")
        reading = _reading({**options, "crs": crs})
        made = cls(_skyshed.Scene.of_buildings(name, wkb, column, names, as_json(reading)), name, reading)
        tell(made._scene.warnings)
        return made

    @property
    def name(self) -> str:
        """What it is called in titles."""
        return self._scene.name

    def map(
        self,
        uav: Uav,
        *,
        progress: object = None,
        **options: Unpack[MapKeywords],
    ) -> Coverage:
        """What a UAV sees: (x, y, height) in the scene's reference system, the height above ground [m] or in words such as
        ``"30roof"``, ``"150amsl"``, ``"400ft"``.

        ``rx_height`` is the receivers' height above ground or roof [m], by default 1.5; ``receivers`` are ``ground``, ``street``,
        ``crossroad``, ``courtyard``, ``roof`` or ``all``; ``radius`` is the largest horizontal distance [m]. ``min_radius`` [m], ``sector``
        (two azimuths, clockwise from grid north), ``elevation`` (two angles from the UAV's horizontal, negative below), ``beam`` (a full
        angle straight down) [deg] and ``slant_range`` (a distance in space) [m] say whom antennas serve; a UAV may have its own as
        ``{"x": …, "sector": (90, 180)}``. ``earth_k`` curves the earth: ``"4/3"`` for radio, ``"7/6"`` for light. ``layers`` are ``los``,
        ``margin``, ``ceiling``, ``least-height``, ``stability``, ``sure`` and ``p-los``; ``zones`` counts by zone. ``height_error``
        and ``height_bias`` are
        standard deviations of errors of heights of buildings [m], of each alone and of all together: P_LoS has an interval then.
        """
        maps = self._scene.maps([uav_of(uav)], as_json(options), True, watch_of(progress))
        tell(maps.warnings, self._scene.warnings)
        return Coverage(maps)

    def maps(
        self,
        uavs: Iterable[Uav],
        *,
        keep: bool = False,
        bad_uavs: Literal["fail", "skip", "lift"] = "fail",
        progress: object = None,
        **options: Unpack[MapKeywords],
    ) -> Coverages:
        """What each of several UAVs sees, and all together: a list, an array of shape (n, 3), or a table with columns x, y, h.

        Masks of single UAVs are made and dropped, or kept with ``keep`` (a byte a cell each). With ``bad_uavs="skip"`` UAVs that cannot be at
        their place are left out, with ``"lift"`` lifted to the top of what is there.
        """
        listed = uavs_of(uavs, self.crs)
        if not listed:
            raise wrong("uavs", "none", "at least one", "E108")
        asked: dict[str, Any] = dict(options) if bad_uavs == "fail" else {**options, "bad_uavs": bad_uavs}
        maps = self._scene.maps(listed, as_json(asked), keep, watch_of(progress))
        tell(maps.warnings, self._scene.warnings)
        return Coverages(maps, self, listed, asked, keep)

    def p_los(self, uavs: Iterable[Uav], *, progress: object = None, **sight: Unpack[SightKeywords]) -> npt.NDArray[np.float64]:
        """P_LoS of each of some UAVs: the share of receivers in range that it sees, NaN without any, and over no data. No mask is made."""
        return self._scene.p_los(uavs_of(uavs, self.crs), as_json(sight), watch_of(progress))

    def link(
        self,
        uav: Uav,
        rx: Sequence[float | str],
        *,
        output: PathLike | Sequence[PathLike] | None = None,
        **options: Unpack[LinkKeywords],
    ) -> Link:
        """One link, decided and explained; ``rx`` is (x, y) or (x, y, height). ``output`` draws it from the side."""
        x, y, h, *_ = uav_of(uav)
        if not isinstance(rx, (tuple, list, np.ndarray)) or len(rx) not in (2, 3):
            raise wrong("rx", repr(rx)[:80], "(x, y) or (x, y, height)", "E103")
        ends = {"uav": [f"{x},{y},{h}"], "rx": [",".join(map(str, rx))]}

        def ask(files: PathLike | Sequence[PathLike] | None = None) -> Found:
            return self._found("link", {**ends, **_of_question(options), **output_of(files)})

        # All that is asked of most links, without a request in words.
        if output is None and not options:
            try:
                if not all(map(math.isfinite, rx)):
                    raise TypeError
                link = self._scene.link((x, y, h), (rx[0], rx[1], rx[2] if len(rx) == 3 else None))
                tell(link[5], [], stacklevel=3)
                return Link(link, ask)
            except (TypeError, Error):
                # Told in the words of the request.
                pass
        found = ask(output)
        tell(found.warnings, self._scene.warnings, stacklevel=3)
        return Link(_quick(json.loads(found.document)), lambda: found)

    def links(
        self,
        uavs: Iterable[Uav],
        receivers: Iterable[Sequence[float | str]],
        *,
        pairs: bool = False,
        los_only: bool = False,
        rx_height: float | str | None = None,
        radius: float | None = None,
        earth_k: float | str | None = None,
        progress: object = None,
    ) -> LinkTable:
        """Links between UAVs and receivers (x, y) or (x, y, height), lists or arrays; with ``pairs`` the k-th of the ones with the k-th
        of the others. ``rx_height`` is that of receivers without their own [m]; beyond ``radius`` [m] a link has no answer.
        ``los_only`` leaves out margins and obstacles, which takes half of the time."""
        listed = receivers.tolist() if isinstance(receivers, np.ndarray) else list(receivers)
        for rx in listed:
            is_place = isinstance(rx, (tuple, list, np.ndarray)) and len(rx) in (2, 3)
            if not is_place or not all(math.isfinite(value) for value in rx if not isinstance(value, str)):
                raise wrong("receivers", repr(rx)[:80], "(x, y) or (x, y, height)", "E103")
        asked = [(rx[0], rx[1], rx[2] if len(rx) == 3 else None) for rx in listed]
        said = {"pairs": pairs, "los_only": los_only, "rx_height": rx_height, "radius": radius, "earth_k": earth_k}
        options = {name: value for name, value in said.items() if value is not None and value is not False}
        try:
            links = self._scene.links(uavs_of(uavs, self.crs), asked, as_json(options), watch_of(progress))  # type: ignore[arg-type]
        except TypeError:
            raise wrong("receivers", "a place that is no number", "(x, y) or (x, y, height)", "E103") from None
        arrays, uav_faults, rx_faults, warnings = links
        tell(warnings, [])
        return LinkTable(arrays, dict(uav_faults), dict(rx_faults))

    def place(
        self,
        *,
        height: float | str | Sequence[float | str] | None = None,
        output: PathLike | Sequence[PathLike] | None = None,
        progress: object = None,
        candidates: Any = None,
        within: Any = None,
        keep_out: Any = None,
        area: Any = None,
        **options: Unpack[PlaceKeywords],
    ) -> Answer:
        """Best places to hover: candidates ranked, refined, or chosen together.

        ``height`` is needed unless ``candidates`` have their own. ``goal`` is ``p_los`` or ``margin``, alone or with ``(street)``,
        ``(crossroad)``, ``(courtyard)``, ``(rooftop)``, ``(area)``: ``place(height=90, goal="p_los(area)", area=polygon)``.
        ``answer["winner"]`` is the best candidate; ``answer["refined"]``, if there is one, is a better place found around it;
        with ``count``, ``answer["several"]`` are those chosen together. Keywords: ``help(skyshed.keywords.PlaceKeywords)``.

        ``candidates`` are a path, or UAVs as for :meth:`maps`; ``within``, ``keep_out`` and ``area`` a path or a geometry. Shares
        are of all receivers of the goal, in range or not.

        >>> best = Scene.itu("urban", size=300).place(height=100, step=50)
        >>> sorted(best["winner"])[:3]
        ['height_agl_m', 'height_amsl_m', 'los']
        """
        given = {"candidates": candidates, "within": within, "keep_out": keep_out, "area": area}
        files, held = inputs_of(given, self.crs, height)
        asked = {"height": height, **files, **_of_question(options), **output_of(output)}
        return self._asked(Answer, "place", asked, progress, held=held)

    def sample(
        self,
        zones: Mapping[str, int],
        *,
        height: float | Sequence[float],
        output: PathLike | Sequence[PathLike] | None = None,
        progress: object = None,
        **options: Unpack[SampleKeywords],
    ) -> Answer:
        """P_LoS averaged over placements of each zone, with intervals: ``{"street": 200, "rooftop": 200}``. Options are those of
        ``skyshed sample``: ``cities``, ``centers``, ``radius``, ``ci``, ``block`` …"""
        of_zones = [f"{zone}:{n}" for zone, n in zones.items()]
        asked = {"zones": of_zones, "height": height, **_of_question(options), **output_of(output)}
        # Generated cities are made as large as whole discs take.
        return self._asked(Answer, "sample", asked, progress, is_opened=self._origin is not None)

    def height_curve(
        self,
        uav: Uav,
        heights: tuple[float, float, float] | None = None,
        *,
        progress: object = None,
        **options: Unpack[SightKeywords],
    ) -> Answer:
        """P_LoS against the height of a UAV above the ground below it, exact: a table of heights, receivers and P_LoS."""
        return self.map(uav, **options).height_curve(heights, progress=progress)

    def track(
        self,
        uav: Uav | Sequence[Uav],
        track: Any,
        *,
        output: PathLike | Sequence[PathLike] | None = None,
        **options: Unpack[TrackKeywords],
    ) -> Answer:
        """Line of sight along a walk or a flight, and its stretches without; of several UAVs for each, and for the best at each place.

        ``track`` is a path (.csv .geojson .gpx .kml .plan .waypoints), a line of shapely, or places in order: a sequence, or an array of
        shape (n, 2) or (n, 3). A third number is a height above ground, in a line of shapely above the datum.
        ``answer["length_m"]`` has lengths [m]: ``los``, ``nlos``, ``inside`` of buildings, ``nodata``; ``answer["stretches"]`` has
        the stretches, ``answer["observers"]`` those of each UAV. Keywords: ``help(skyshed.keywords.TrackKeywords)``.
        """
        held: list[HeldInput] = []
        listed = uavs_of([uav] if is_one_uav(uav) else uav, self.crs, None)
        observers = {"uav": [f"{x},{y},{h}" for x, y, h, *_ in listed]}
        path, table = track_of(track)
        if table is not None:
            held.append(("track", path, table))
        asked = {**observers, "track": path, **_of_question(options), **output_of(output)}
        return self._asked(Answer, "track", asked, held=held)

    def limits(
        self,
        uavs: Iterable[Uav],
        *,
        output: PathLike | Sequence[PathLike] | None = None,
        **options: Unpack[LimitsKeywords],
    ) -> Answer:
        """Limits of the P_LoS of a map of some UAVs: cells, terrain, positions, heights; a row for each.

        ``p_los_change`` is the change of P_LoS where a part is as the column ``changed`` says. ``output`` is .csv or .json. Keywords:
        ``help(skyshed.keywords.LimitsKeywords)``.
        """
        asked, held = self._of_uavs(uavs)
        return self._asked(Answer, "limits", {**asked, **_of_question(options), **output_of(output)}, held=held)

    def compare(
        self,
        uavs: Iterable[Uav] = (),
        *,
        masks: Sequence[PathLike] = (),
        output: PathLike | Sequence[PathLike] | None = None,
        **options: Unpack[CompareKeywords],
    ) -> Answer:
        """UAVs side by side, and saved maps (``masks``): counts, shares, differences with intervals. ``output`` may be a page (.html).

        ``answer["placements"]`` has the counts, ``answer["pairs"]`` the differences of two with intervals of 95 %, ``answer["verdict"]``
        the best in words. Keywords: ``help(skyshed.keywords.CompareKeywords)``.
        """
        asked, held = self._of_uavs(uavs) if uavs_of(uavs, self.crs) else ({}, [])
        of_masks = {"mask": list(masks)} if masks else {}
        asked = {**asked, **of_masks, **_of_question(options), **output_of(output)}
        return self._asked(Answer, "compare", asked, held=held)

    def zones(
        self, *, output: PathLike | Sequence[PathLike] | None = None, **options: Unpack[ZonesKeywords]
    ) -> Answer:
        """Streets, crossroads, courtyards and rooftops: cells and shares of each. ``output`` draws a map, or holds polygons."""
        return self._asked(Answer, "zones", {**_of_question(options), **output_of(output)})

    def _of_uavs(self, uavs: Iterable[Uav]) -> tuple[dict[str, object], list[HeldInput]]:
        """UAVs as a table in memory."""
        listed = uavs_of(uavs, self.crs)
        if not listed:
            raise wrong("uavs", "none", "at least one", "E108")
        return {"uavs": "uavs.csv"}, [("uavs", "uavs.csv", table_of(listed))]

    def live(self, path: PathLike | None = None, *, uavs: Iterable[Uav] = (), track: Any = None) -> LivePage:
        """A page in which UAVs are dragged over the scene and the exact coverage follows; it is written to ``path``, and shown by a
        notebook. A ``track``, as of :meth:`track`, is shown from the side in its stretches with line of sight and without."""
        asked = None if track is None else track_of(track)
        page = LivePage(self._scene.live_page(uavs_of(uavs, self.crs), asked, self._word, as_json(self._reading)))
        if path is not None:
            page.save(path)
        return page

    def save(self, *paths: PathLike, **options: Unpack[CityKeywords]) -> None:
        """Writes the city itself: a drawing (.png .svg .pdf), heights (.tif .asc), footprints (.geojson), a scene of Mitsuba and Sionna
        RT (.xml), boxes of ns-3 (.csv), a document (.json). Options are those of ``skyshed city``."""
        self._asked(Answer, "city", {**_of_question(options), **output_of(paths)})

    def _asked(
        self,
        kind: type[_Kind],
        command: str,
        asked: Mapping[str, object],
        progress: object = None,
        is_opened: bool = False,
        held: Sequence[HeldInput] = (),
    ) -> _Kind:
        """Asks a command of the program over this scene, or over one that it opens itself."""
        found = self._found(command, asked, progress, is_opened, held)
        tell(found.warnings, self._scene.warnings, stacklevel=4)
        return kind(found)

    def _found(
        self,
        command: str,
        asked: Mapping[str, object],
        progress: object = None,
        is_opened: bool = False,
        held: Sequence[HeldInput] = (),
    ) -> Found:
        # The name of a scene in memory names no file.
        options = {**self._reading, "scene": self._word} if self._origin else {"scene": "memory"}
        if is_opened and self._origin:
            options = {**self._origin.options, "scene": self._origin.word}
        scene = None if is_opened else self._scene
        return _skyshed.ask(command, as_json({**options, **asked}), scene, watch_of(progress), list(held))

    def __reduce__(self) -> tuple[Any, ...]:
        if self._origin:
            return _reopened, (type(self), self._origin)
        return _unpacked, (type(self), self._word, self._scene.name, self._scene.packed(), self.crs, self._reading)

    def __repr__(self) -> str:
        n_rows, n_cols = self.shape
        return f"Scene({self.name!r}, {n_rows}×{n_cols} cells, crs={self.crs!r})"


def _quick(document: Mapping[str, Any]) -> _Link:
    """A link of its document."""
    of = document["obstruction"]
    place = of and (of["kind"], of.get("id"), of.get("row"), of.get("col"), of["x"], of["y"], of["ray_height_m"], of["roof_height_m"])
    return document["los"], document["margin_m"], document["distance_m"], document["elevation_deg"], place, []


def _reopened(cls: type[Scene], origin: Origin) -> Scene:
    return cls(_skyshed.Scene.open(origin.word, as_json(origin.options)), origin.word, origin.options, origin)


def _listed(path: PathLike | Sequence[PathLike]) -> Sequence[PathLike]:
    return [path] if isinstance(path, (str, os.PathLike)) else path


def _parts(word: str) -> list[str]:
    """The files of a word such as ``a.geojson+b.geojson``."""
    return [word] if os.path.exists(word) or "://" in word else word.split("+")


def origin_of(path: PathLike | Sequence[PathLike], options: Mapping[str, object]) -> Origin:
    """What a scene of files is opened by, wherever a process is."""
    of_files = {name: _absolute(value) if name in ("terrain", "data_area") else value for name, value in options.items()}
    parts = [part for file in _listed(path) for part in _parts(os.fspath(file))]
    return Origin("+".join(map(_absolute, parts)), _reading(of_files))


def opened_once(origin: Origin) -> Scene:
    """A scene of files, which this process opens once unless one of them changes."""
    paths = [*_parts(origin.word), *(value for value in origin.options.values() if isinstance(value, str))]
    files = [path for path in paths if os.path.exists(path)]
    files += [member.path for path in files if os.path.isdir(path) for member in os.scandir(path)]
    changed = tuple((path, os.stat(path).st_mtime_ns, os.stat(path).st_size) for path in files)
    return _opened(origin.word, as_json(origin.options), changed)


@lru_cache(maxsize=2)
def _opened(word: str, options: str, changed: tuple[tuple[str, int, int], ...]) -> Scene:
    return _reopened(Scene, Origin(word, json.loads(options)))


def _absolute(path: Any) -> Any:
    """A path that means the same wherever a process is; words that are no path stay."""
    is_word = path is None or str(path) in ("auto", "all", "-") or str(path).startswith(("itu:", "http://", "https://", "s3://"))
    return path if is_word else os.path.abspath(os.fspath(path))


def _of_question(options: Mapping[str, object]) -> Mapping[str, object]:
    """Options of a question; those of a scene are given where it is made."""
    of_scene = [name for name in options if name in READING or name in ("size", "seed")]
    if of_scene:
        raise wrong(of_scene[0], "an option of scenes", "options of the question: give it where the scene is made", "E116")
    return options


def _unpacked(cls: type[Scene], word: str, name: str, packed: bytes, crs: str | None, reading: dict[str, Any]) -> Scene:
    return cls(_skyshed.Scene.unpacked(name, packed, crs), word, reading)


def _reading(options: Mapping[str, object]) -> dict[str, Any]:
    """Options that say how a scene is read; reference systems may be objects of other packages."""
    said = dict(options)
    for name in ("crs", "project"):
        said[name] = crs_text(name, said.get(name))
    return plain_options(said)


def _wkb(k: int, shape: Any) -> bytes:
    """A geometry as well-known binary."""
    if isinstance(shape, (bytes, bytearray)):
        return bytes(shape)
    if hasattr(shape, "wkb"):
        return bytes(shape.wkb)
    mapping = getattr(shape, "__geo_interface__", shape)
    if isinstance(mapping, Mapping) and mapping.get("type") in ("Polygon", "MultiPolygon"):
        polygons = mapping["coordinates"] if mapping["type"] == "MultiPolygon" else [mapping["coordinates"]]
        return _multipolygon(polygons)
    raise wrong(f"buildings[{k}]", repr(shape)[:80], "a polygon of shapely, well-known binary, or a mapping as of GeoJSON")


def _multipolygon(polygons: Any) -> bytes:
    from struct import pack

    parts = [pack("<BII", 1, 6, len(polygons))]
    for rings in polygons:
        parts.append(pack("<BII", 1, 3, len(rings)))
        for ring in rings:
            points = np.ascontiguousarray([point[:2] for point in ring], dtype="<f8").reshape(-1, 2)
            parts += [pack("<I", len(points)), points.tobytes()]
    return b"".join(parts)


def plos(
    *scenes: str | PathLike | Scene,
    height: float | Sequence[float] = 100,
    output: PathLike | Sequence[PathLike] | None = None,
    progress: object = None,
    **options: Unpack[PlosKeywords],
) -> Answer:
    """The probability of line of sight over cities that are known by statistics, or over real ones: exact products, simulators,
    models, maps. Options are those of ``skyshed plos``: ``theta``, ``distance``, ``radius``, ``method``, ``placement``, ``users``,
    ``cities``, ``until``, ``ci`` …

    >>> found = plos("itu:urban", height=100, theta=[30, 60])
    >>> [round(float(p), 3) for p in found.table["p_los"]]
    [0.467, 0.779]
    """
    if not scenes:
        raise wrong("scenes", "none", 'at least one, such as "itu:urban"', "E108")
    words: list[str] = []
    readings: list[dict[str, Any]] = []
    for city in scenes:
        if isinstance(city, Scene) and city._origin is None:
            raise wrong("scenes", f"{city!r}, made of arrays", "a file or a generated city: save it and open that")
        origin = city._origin if isinstance(city, Scene) else None
        words.append(origin.word if origin else os.fspath(city))  # type: ignore[arg-type]
        reading = origin.options if origin else {}
        readings.append({name: value for name, value in reading.items() if name not in ("size", "seed")})
    if any(reading != readings[0] for reading in readings):
        raise wrong("scenes", "cities that are read in different ways", "one way for all of them, or a call for each")
    asked = {**readings[0], "scenes": words, "height": height, **options, **output_of(output)}
    found = _skyshed.ask("plos", as_json(asked), None, watch_of(progress))
    tell(found.warnings)
    return Answer(found)


def info(path: PathLike, *, output: PathLike | Sequence[PathLike] | None = None, **options: Unpack[InfoKeywords]) -> Answer:
    """Facts of a file, as of ``skyshed info``: size, reference system, heights and faults of a scene; what UAVs or an output hold.

    >>> found = info("itu:urban", size=200)
    >>> found["cols"], found["rows"]
    (200, 200)
    """
    found = _skyshed.ask("info", as_json({**_reading(options), "scene": os.fspath(path), **output_of(output)}))
    tell(found.warnings)
    return Answer(found)

"""Units of work over the workers of a Dask cluster: files of many sites or tiles, P_LoS of many UAVs, ranks of candidates.

A unit is one site, or one tile of the ground. Its files depend on the scene, the unit and the options alone, appear when they are
complete, and are left alone where they are. So workers may die, units may be handed out twice, and a driver that was killed goes on
where it was::

    client = Client(processes=True)
    map_sites("munich.geojson", sites, "out/{site}.tif", client=client, radius=300)
    map_tiles("dsm.tif", sites, "out/{row}-{col}.tif", client=client, radius=2000, layers="count")

A worker opens a scene of footprints once; of a raster file it reads what each unit needs. It takes as many threads as its cluster gives
it, and refuses what would take more than its memory limit. Tasks stand in the dashboard under the names of these functions.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from distributed import Client, as_completed, get_client, get_worker
from distributed.scheduler import KilledWorker

from skyshed import _cluster, _skyshed
from skyshed._answers import COUNT, flags
from skyshed._answers import Grid as CellGrid
from skyshed._cluster import DEATHS, Mapped, Options, SceneOrPath, Tile
from skyshed._errors import Error, wrong
from skyshed._inputs import AskedUav, table_of
from skyshed._options import PathLike, as_json
from skyshed._scene import Scene

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray

__all__ = ["Mapped", "map_sites", "map_tiles", "p_los", "place", "tiles"]


def map_sites(
    scene: SceneOrPath,
    sites: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    *,
    client: Client | None = None,
    batch: int | None = None,
    **options: object,
) -> Mapped:
    """Maps each site into files of its own, over the workers of a cluster; ``{site}`` in ``out`` is its name.

    ``scene`` is a :class:`Scene` or the path of one. Sites are as for :meth:`Scene.maps`, options those of ``skyshed map``. Files that
    are there, made by an equal run, are left alone. ``batch`` sites go to a worker at a time, by default as many as take two seconds.

    Raises an :class:`Error` that names the sites that failed, once all others are done.
    """
    return _cluster.map_sites(_Dask(client), scene, sites, out, batch, options)


def map_tiles(
    scene: SceneOrPath,
    uavs: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    *,
    tile_size: int = 2048,
    client: Client | None = None,
    batch: int | None = None,
    **options: object,
) -> Mapped:
    """Maps what all UAVs see together, tile by tile over the workers of a cluster; ``{row}`` and ``{col}`` in ``out`` are a tile's.

    ``tile_size`` is the number of cells along a side, ``layers`` are of all UAVs: ``count``, ``union``, ``which``, ``best-server``. A tile
    takes the UAVs that have a cell of it within ``radius``; of a raster file no more is read than the ground from the tile to these.
    ``skyshed jobs merge`` joins the files into a mosaic.

    Raises an :class:`Error` that names the tiles that failed, once all others are done.
    """
    return _cluster.map_tiles(_Dask(client), scene, uavs, out, tile_size, batch, options)


def p_los(
    scene: Scene, uavs: Iterable[Any], *, client: Client | None = None, batch: int | None = None, **sight: object
) -> npt.NDArray[np.float64]:
    """P_LoS of each of some UAVs, as :meth:`Scene.p_los`, over the workers of a cluster."""
    return _cluster.p_los(_Dask(client), scene, uavs, batch, sight)


def place(
    scene: SceneOrPath, *, height: object, client: Client | None = None, batch: int | None = None, **options: object
) -> list[dict[str, str]]:
    """Candidates to hover at, best first, as ``skyshed place`` ranks them, over the workers of a cluster: rows of its table.

    ``batch`` is the number of parts. Goals are those of ``p_los``; several UAVs are chosen by :meth:`Scene.place`.
    """
    return _cluster.place(_Dask(client), scene, height, batch, options)


def tiles(
    scene: SceneOrPath, uavs: Iterable[Any], *, layer: str = "count", tile_size: int = 2048, **options: object
) -> xarray.DataArray:
    """A layer of all UAVs together as an array of Dask chunks, one for each tile, made when it is computed.

    ``layer`` is ``count``, ``union`` or ``best-server``. Values, coordinates and attributes are those of :meth:`Coverages.to_xarray`: 0 where
    no UAV sees a cell, also where nobody receives. The number of the best server is its place in the list, from 1.
    """
    import dask.array
    import xarray
    from dask.delayed import delayed

    chunks: Any = dask.array

    if layer not in ("count", "union", "best-server"):
        raise wrong("layer", repr(layer), "count, union or best-server", "E107")
    asked, crs, others = _cluster._asked(scene, options)
    listed = _cluster.named(_cluster._listed(uavs, crs))
    others = {**others, "layers": layer, "tile_size": tile_size, "output": ["{row}-{col}.npz"]}
    units = _cluster.planned(asked, listed, others)
    others.pop("output")
    place = _cluster.grid_in_parts(asked) or _cluster.opened(asked)._scene.place
    n_rows, n_cols = place[0]
    dtype = np.uint8 if layer == "union" else np.uint32
    blocks: dict[Tile, Any] = {}
    for unit in units:
        tile, own = unit.tile, _cluster.uavs_of_part([unit], listed, others)
        shape = (min(tile_size, n_rows - tile[0] * tile_size), min(tile_size, n_cols - tile[1] * tile_size))
        array = delayed(_layer_of_tile, pure=True)(asked, tile, own, others, layer)
        blocks[tile] = chunks.from_delayed(array, shape, dtype)
    rows = sorted({row for row, _ in blocks})
    data = chunks.block([[blocks[row, col] for r, col in blocks if r == row] for row in rows])
    attributes = {"union": flags(), "count": COUNT}.get(layer, {"long_name": "nearest UAV in line of sight", "units": "1"})
    coordinates = CellGrid(place).coordinates()
    return xarray.DataArray(data, coordinates, ("y", "x"), layer, attributes | {"grid_mapping": "spatial_ref"})


def _layer_of_tile(asked: Any, tile: Tile, uavs: list[AskedUav], options: Options, layer: str) -> npt.NDArray[Any]:
    _prepare()
    of_tile = as_json({**_cluster.of_scene(asked), **options, "tile": [f"{tile[0]},{tile[1]}"]})
    maps = _skyshed.map_tile(of_tile, _cluster.held_scene(asked), table_of(uavs))
    if layer == "union":
        return maps.union()
    return maps.count() if layer == "count" else maps.together(layer)


def _prepare() -> None:
    """Keeps to what this worker may take."""
    try:
        worker = get_worker()
    except ValueError:
        return
    _cluster.prepare(worker.state.nthreads, getattr(getattr(worker, "memory_manager", None), "memory_limit", None))


def _work(work: Callable[..., Any], asked: Any, part: Any, options: Options) -> Any:
    _prepare()
    return work(asked, part, options)


def _names(part: Any) -> str:
    """What a part holds, in a few words."""
    units = part[0] if isinstance(part, tuple) and isinstance(part[0], list) else part
    names = [f"tile {unit[0]},{unit[1]}" if len(unit) == 2 else str(unit[3]) for unit in units[:3]] if isinstance(units, list) else [str(units)]
    return ", ".join(names) + (" …" if isinstance(units, list) and len(units) > 3 else "")


class _Dask:
    """The workers of a Dask cluster."""

    def __init__(self, client: Client | None) -> None:
        self._client = client or get_client()

    def share(self, scene: Scene) -> Any:
        """The scene itself, to each worker once."""
        scatter: Any = self._client.scatter
        return scatter(scene, broadcast=True, hash=False)

    def run(self, name: str, work: Callable[..., Any], asked: Any, parts: Sequence[Any], options: Options) -> list[Any]:
        """What workers make of parts, in their order. A part whose workers die is handed out again."""
        token = uuid.uuid4().hex

        def submit(k: int, again: int = 0) -> Any:
            return self._client.submit(_work, work, asked, parts[k], options, key=(f"{name}-{token}", k, again), pure=False, retries=2)

        futures = {submit(k): k for k in range(len(parts))}
        deaths = dict.fromkeys(range(len(parts)), 0)
        found: dict[int, Any] = {}
        fatal: list[int] = []
        as_done: Any = as_completed
        running = as_done(futures)
        for future in running:
            k = futures.pop(future)
            try:
                found[k] = future.result()
            except KilledWorker:
                deaths[k] += 1
                if deaths[k] > DEATHS:
                    # All others are done first.
                    fatal.append(k)
                    continue
                again = submit(k, deaths[k])
                futures[again] = k
                running.add(again)
        if fatal:
            told = ", ".join(_names(parts[k]) for k in fatal[:5])
            raise Error(f"workers die over {len(fatal)} of {len(parts)} parts of {name}, the others are done: {told}: is there memory enough?", "E501")
        return [found[k] for k in range(len(parts))]

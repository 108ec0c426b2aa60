"""Units of work over the processes of a Ray cluster, by the interface of :mod:`skyshed.dask`::

    ray.init()
    map_tiles("dsm.tif", sites, "out/{row}-{col}.tif", radius=2000, layers="count")
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import ray

from skyshed import _cluster
from skyshed._cluster import DEATHS, Mapped, Options, SceneOrPath
from skyshed._options import PathLike
from skyshed._scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

__all__ = ["Mapped", "map_sites", "map_tiles", "p_los", "place"]


def map_sites(
    scene: SceneOrPath, sites: Iterable[Any], out: PathLike | Sequence[PathLike], *, batch: int | None = None, **options: object
) -> Mapped:
    """Maps each site into files of its own: see :func:`skyshed.dask.map_sites`."""
    return _cluster.map_sites(_Ray(), scene, sites, out, batch, options)


def map_tiles(
    scene: SceneOrPath,
    uavs: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    *,
    tile_size: int = 2048,
    batch: int | None = None,
    **options: object,
) -> Mapped:
    """Maps what all UAVs see together, tile by tile: see :func:`skyshed.dask.map_tiles`."""
    return _cluster.map_tiles(_Ray(), scene, uavs, out, tile_size, batch, options)


def p_los(scene: Scene, uavs: Iterable[Any], *, batch: int | None = None, **sight: object) -> npt.NDArray[np.float64]:
    """P_LoS of each of some UAVs: see :func:`skyshed.dask.p_los`."""
    return _cluster.p_los(_Ray(), scene, uavs, batch, sight)


def place(scene: SceneOrPath, *, height: object, batch: int | None = None, **options: object) -> list[dict[str, str]]:
    """Candidates to hover at, best first: see :func:`skyshed.dask.place`."""
    return _cluster.place(_Ray(), scene, height, batch, options)


def _do(work: Callable[..., Any], asked: Any, part: Any, options: Options) -> Any:
    # A task has one processor unless it asks for more.
    _cluster.prepare(1, None)
    return work(asked, part, options)


#: As a task, which is run again if its process dies.
_work: Any = ray.remote(max_retries=DEATHS)(_do)


class _Ray:
    """The processes of a Ray cluster, which runs parts again whose process died."""

    def share(self, scene: Scene) -> Any:
        return ray.put(scene)

    def run(self, name: str, work: Callable[..., Any], asked: Any, parts: Sequence[Any], options: Options) -> list[Any]:
        task = _work.options(name=name)
        found: list[Any] = ray.get([task.remote(work, asked, part, options) for part in parts])
        return found

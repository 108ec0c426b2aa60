"""Work over many processes, whoever runs them: units of a map, P_LoS of many UAVs, candidates of a search.

A cluster is asked to run one function over parts of a list, and to run a part again whose process died. All else is here: what a part
holds, how large it is, what a process opens, and what is told at the end.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Union

import numpy as np

from skyshed import _skyshed
from skyshed._errors import Error, wrong
from skyshed._inputs import AskedUav, table_of, uavs_of
from skyshed._options import PathLike, as_json
from skyshed._scene import READING, Origin, Scene, opened_once, origin_of

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import TypeAlias

#: A part takes about so long [s]: much to a scheduler, little to do again.
TASK_S = 2.0
#: Most units of a part.
MOST_A_TASK = 500
#: How often processes may die over one part.
DEATHS = 10
#: Layers that tell UAVs by their places in the list of all.
NUMBERED = ("which", "best-server")

#: What a process opens: the name of a scene, or the scene itself.
Asked: TypeAlias = Union[Scene, Origin]
#: A scene, or the path of one, which the driver need not open.
SceneOrPath: TypeAlias = Union[Scene, PathLike]
Tile = tuple[int, int]
#: Options of a question by their names.
Options: TypeAlias = "Mapping[str, object]"


class Mapped(NamedTuple):
    """What became of the units of a run."""

    #: Units whose files were made.
    mapped: int
    #: Units whose files were there.
    there: int


class Unit(NamedTuple):
    """A unit of work, as the program cuts it."""

    name: str
    #: Row and column of a tile; ``None`` of a UAV.
    tile: Any
    #: Its UAVs, by their places in the list of all.
    uavs: list[int]
    #: About how long it takes on one thread [s].
    seconds: float


class Cluster(Protocol):
    """Who runs parts."""

    def share(self, scene: Scene) -> Any:
        """What a task is given of a scene that has no name."""

    def run(self, name: str, work: Callable[..., Any], asked: Any, parts: Sequence[Any], options: Options) -> list[Any]:
        """What ``work(asked, part, options)`` makes of each part, in their order."""


def map_sites(
    cluster: Cluster,
    scene: SceneOrPath,
    sites: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    batch: int | None,
    options: Mapping[str, object],
) -> Mapped:
    _checked(batch, None, options)
    asked, crs, options = _asked(scene, options)
    listed = named(_listed(sites, crs))
    options = {**options, "resume": True, "output": _outputs(out, ["{site}"])}
    of_part = batched(planned(asked, listed, options), batch)
    parts = [[listed[k] for unit in part for k in unit.uavs] for part in of_part]
    done = cluster.run("map_sites", map_some, _shared(cluster, asked), parts, options)
    return _told(done, "sites", len(listed))


def map_tiles(
    cluster: Cluster,
    scene: SceneOrPath,
    uavs: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    tile_size: int,
    batch: int | None,
    options: Mapping[str, object],
) -> Mapped:
    _checked(batch, tile_size, options)
    asked, crs, options = _asked(scene, options)
    listed = named(_listed(uavs, crs))
    options = {**options, "tile_size": tile_size, "resume": True, "output": _outputs(out, ["{row}", "{col}"])}
    units = planned(asked, listed, options)
    parts = [([unit.tile for unit in part], uavs_of_part(part, listed, options)) for part in batched(units, batch)]
    done = cluster.run("map_tiles", map_some_tiles, _shared(cluster, asked), parts, options)
    return _told(done, "tiles", len(units))


def p_los(
    cluster: Cluster, scene: SceneOrPath, uavs: Iterable[Any], batch: int | None, sight: Mapping[str, object]
) -> npt.NDArray[np.float64]:
    if not isinstance(scene, Scene):
        raise wrong("scene", repr(scene), "a Scene")
    _checked(batch, None, {})
    listed = _listed(uavs, scene.crs)
    size = batch or min(MOST_A_TASK, max(len(listed) // 8, 1))
    parts = [listed[first : first + size] for first in range(0, len(listed), size)]
    counted = cluster.run("p_los", p_los_of_some, _shared(cluster, scene._origin or scene), parts, dict(sight))
    found: npt.NDArray[np.float64] = np.concatenate(counted)
    return found


def place(
    cluster: Cluster, scene: SceneOrPath, height: object, batch: int | None, options: Mapping[str, object]
) -> list[dict[str, str]]:
    """The candidates of all parts, best first as the program ranks them."""
    goal = str(options.get("goal") or "p_los")
    if not goal.startswith("p_los"):
        raise wrong("goal", repr(goal), "p_los, alone or of some receivers", "E116")
    refused = [name for name in ("output", "map", "count", "minimize", "refine", "shard") if options.get(name) not in (None, False, 1)]
    if refused:
        raise wrong(refused[0], repr(options[refused[0]]), "no such option: over many processes candidates are ranked one by one", "E116")
    _checked(batch, None, options)
    asked, _, options = _asked(scene, options)
    n = batch or 8
    parts = [(k + 1, n) for k in range(n)]
    options = {**options, "height": height}
    tables: list[list[dict[str, str]]] = cluster.run("place", rank_some, _shared(cluster, asked), parts, options)
    # Of equal shares the first in the order of the candidates, as in one run.
    rows = [row for table in tables for row in table]
    if not rows:
        raise Error("no candidate is left", "E209")
    rows.sort(key=lambda row: -float(row["p_los"] or "-1"))
    return [{**row, "rank": str(k + 1)} for k, row in enumerate(rows)]


# What the driver knows.


def _asked(scene: SceneOrPath, options: Mapping[str, object]) -> tuple[Asked, str | None, dict[str, object]]:
    """What processes open, its reference system, and the options that do not say how it is read."""
    if isinstance(scene, Scene):
        return scene._origin or scene, scene.crs, dict(options)
    reading = {name: value for name, value in options.items() if name in READING}
    others = {name: value for name, value in options.items() if name not in READING}
    origin = origin_of(scene, reading)
    found = grid_in_parts(origin)
    if found is None:
        return origin, opened_once(origin).crs, others
    return origin, found[2][0] if found[2] else None, others


def _shared(cluster: Cluster, asked: Asked) -> Any:
    return asked if isinstance(asked, Origin) else cluster.share(asked)


def named(uavs: list[AskedUav]) -> list[AskedUav]:
    """UAVs that all have names: those of the program."""
    return [(x, y, h, str(k + 1) if id is None else id, antenna, time) for k, (x, y, h, id, antenna, time) in enumerate(uavs)]


def _listed(sites: Iterable[Any], crs: str | None) -> list[AskedUav]:
    listed = uavs_of(sites, crs)
    if not listed:
        raise wrong("sites", "none", "at least one", "E108")
    return listed


def _outputs(out: PathLike | Sequence[PathLike], wanted: list[str]) -> list[str]:
    """Files of units, whose folders are made."""
    outputs = [os.path.abspath(file) for file in ([out] if isinstance(out, (str, os.PathLike)) else out)]
    if not all(word in file for word in wanted for file in outputs):
        raise wrong("out", repr(out), f"names with {' and '.join(wanted)}, such as out/{'-'.join(wanted)}.tif", "E105")
    for folder in {os.path.dirname(file) for file in outputs if "{" not in os.path.dirname(file)}:
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise Error(f"cannot make the folder {folder}: {error.strerror}", "E401") from None
    return outputs


def _checked(batch: int | None, tile_size: int | None, options: Mapping[str, object]) -> None:
    """Refuses what cannot be, and what is decided here."""
    if batch is not None and batch < 1:
        raise wrong("batch", repr(batch), "at least 1", "E113")
    if tile_size is not None and (tile_size < 16 or tile_size % 16):
        raise wrong("tile_size", repr(tile_size), "a multiple of 16", "E101")
    for name in ("shard", "tile", "resume", "uav", "uavs", "output"):
        if options.get(name) not in (None, False):
            raise wrong(name, repr(options[name]), "no such option: parts are made here", "E116")


def _told(done: list[tuple[Mapped, list[tuple[str, Error]]]], what: str, n: int) -> Mapped:
    """The sum of all parts; an error that names the units that failed."""
    failed = [failure for _, failures in done for failure in failures]
    if failed:
        texts = [(id, str(why)) for id, why in failed[:5]]
        told = "; ".join(text if id in text else f"{id}: {text}" for id, text in texts)
        more = f"; and {len(failed) - 5} more" if len(failed) > 5 else ""
        # The code of the first, as the program has it.
        raise Error(f"{len(failed)} of {n} {what} failed, the others are done: {told}{more}", failed[0][1].code)
    return Mapped(sum(part.mapped for part, _ in done), sum(part.there for part, _ in done))


def batched(units: list[Unit], batch: int | None) -> list[list[Unit]]:
    """Units in parts of about two seconds, by the forecast of each, or of as many as are wanted; eight parts or more of small work."""
    most = batch or min(MOST_A_TASK, max(len(units) // 8, 1))
    parts: list[list[Unit]] = [[]]
    seconds = 0.0
    for unit in units:
        is_full = len(parts[-1]) == most or not batch and seconds + unit.seconds > TASK_S
        if parts[-1] and is_full:
            parts.append([])
            seconds = 0.0
        parts[-1].append(unit)
        seconds += unit.seconds
    return parts


def planned(asked: Asked, listed: list[AskedUav], options: Mapping[str, object]) -> list[Unit]:
    """The units of a map, as the program cuts them."""
    units = _skyshed.plan_units(as_json({**of_scene(asked), **options}), held_scene(asked), table_of(listed))
    return [Unit(*unit) for unit in units]


def uavs_of_part(part: list[Unit], listed: list[AskedUav], options: Mapping[str, object]) -> list[AskedUav]:
    """The UAVs that some tiles need; all of them where a layer tells their places in the list."""
    layers = options.get("layers") or ()
    names = layers.split(",") if isinstance(layers, str) else list(layers)  # type: ignore[call-overload]
    if any(name in NUMBERED for name in names):
        return listed
    # A table without rows is no table: the program leaves out who is too far.
    return [listed[k] for k in sorted({k for unit in part for k in unit.uavs})] or listed[:1]


# What a process does.


def prepare(threads: int | None, memory: int | None) -> None:
    """Keeps to what a process may take: its threads, and its memory [bytes], beyond which work is refused before it begins."""
    if threads:
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))
    if memory:
        _skyshed.limit_memory(int(0.95 * memory))


def opened(asked: Asked) -> Scene:
    """The scene itself."""
    return opened_once(asked) if isinstance(asked, Origin) else asked


def grid_in_parts(asked: Asked) -> _skyshed._Place | None:
    """The grid of a raster file, of which a run reads no more than it needs; ``None`` for other scenes."""
    return _skyshed.raster_grid(asked.word, as_json(asked.options)) if isinstance(asked, Origin) else None


def held_scene(asked: Asked) -> _skyshed.Scene | None:
    """The scene that runs share; ``None`` if each reads its part."""
    return None if grid_in_parts(asked) is not None else opened(asked)._scene


def of_scene(asked: Asked) -> dict[str, Any]:
    """Options that name a scene and say how it is read."""
    return {**asked.options, "scene": asked.word} if isinstance(asked, Origin) else {"scene": "memory"}


def p_los_of_some(asked: Asked, sites: list[AskedUav], options: Options) -> npt.NDArray[np.float64]:
    return opened(asked)._scene.p_los(sites, as_json(options))


def map_some(asked: Asked, sites: list[AskedUav], options: Options) -> tuple[Mapped, list[tuple[str, Error]]]:
    """Files of some sites; those that fail are told one by one."""
    try:
        return _map(asked, sites, options), []
    except (Error, OSError):
        return _one_by_one((str(site[3]), lambda site=site: _map(asked, [site], options)) for site in sites)  # type: ignore[misc]


def map_some_tiles(
    asked: Asked, part: tuple[list[Tile], list[AskedUav]], options: Options
) -> tuple[Mapped, list[tuple[str, Error]]]:
    """Files of some tiles; those that fail are told one by one."""
    tiles, uavs = part

    def map_tiles(some: list[Tile]) -> Mapped:
        return _map(asked, uavs, {**options, "tile": [f"{row},{col}" for row, col in some]})

    try:
        return map_tiles(tiles), []
    except (Error, OSError):
        return _one_by_one((f"tile {row},{col}", lambda tile=(row, col): map_tiles([tile])) for row, col in tiles)  # type: ignore[misc]


def _one_by_one(runs: Iterable[tuple[str, Callable[[], Mapped]]]) -> tuple[Mapped, list[tuple[str, Error]]]:
    done, failed = Mapped(0, 0), []
    for name, run in runs:
        try:
            own = run()
            done = Mapped(done.mapped + own.mapped, done.there + own.there)
        except Error as error:
            failed.append((name, error))
        except OSError as error:
            failed.append((name, Error(str(error), "E401")))
    return done, failed


def _map(asked: Asked, uavs: list[AskedUav], options: Options) -> Mapped:
    options = {**of_scene(asked), **options, "uavs": "uavs.csv"}
    found = _skyshed.ask("map", as_json(options), held_scene(asked), None, [("uavs", "uavs.csv", table_of(uavs))])
    counts = json.loads(found.document)
    return Mapped(counts["mapped"], counts["there"])


def rank_some(asked: Asked, part: tuple[int, int], options: Options) -> list[dict[str, str]]:
    """The ranks of a part of the candidates."""
    options = {**of_scene(asked), **options, "shard": f"{part[0]}/{part[1]}"}
    try:
        found = _skyshed.ask("place", as_json(options), opened(asked)._scene)
    except Error as error:
        # Others may have some.
        if error.code == "E209":
            return []
        raise
    header, *rows = found.table
    named = (dict(zip(header, row)) for row in rows)
    return [row for row in named if row["kind"] == "candidate"]

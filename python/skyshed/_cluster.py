"""Work over many processes, whoever runs them: units of a map, P_LoS of many UAVs, candidates of a search.

A cluster is asked to run one function over parts of a list, and to run a part again whose process died. All else is here: what a part
holds, how large it is, what a process opens, and what is told at the end.
"""

from __future__ import annotations

import csv
import json
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Union

import numpy as np

from skyshed import _skyshed
from skyshed._errors import Error, wrong
from skyshed._scene import READING, Origin, Scene, opened_once, origin_of
from skyshed._words import AskedUav, PathLike, files_of, table_of, uavs_of, words_of

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import TypeAlias

#: A part takes about so long [s]: much to a scheduler, little to do again.
TASK_S = 2.0
#: Most units of a part.
MOST_A_TASK = 500
#: How often processes may die over one part.
DEATHS = 10
#: Nanoseconds that a cell of a tile takes beside the line of sight, and those that a cell in range of a UAV takes.
CELL_NS, SEEN_NS = 45.0, 10.0
#: Layers that tell UAVs by their places in the list of all.
NUMBERED = ("which", "best-server")

#: What a process opens: the name of a scene, or the scene itself.
Asked: TypeAlias = Union[Scene, Origin]
#: A scene, or the path of one, which the driver need not open.
SceneOrPath: TypeAlias = Union[Scene, PathLike]
Tile = tuple[int, int]


class Mapped(NamedTuple):
    """What became of the units of a run."""

    #: Units whose files were made.
    mapped: int
    #: Units whose files were there.
    there: int


class Grid(NamedTuple):
    """Where the cells of a scene lie."""

    shape: tuple[int, int]
    #: West edge, width of a cell, north edge, height of a cell.
    place: tuple[float, float, float, float]
    #: Label and WKT of the reference system.
    crs: tuple[str, str | None] | None


class Cluster(Protocol):
    """Who runs parts."""

    def share(self, scene: Scene) -> Any:
        """What a task is given of a scene that has no name."""

    def run(self, name: str, work: Callable[..., Any], asked: Any, parts: Sequence[Any], words: list[str]) -> list[Any]:
        """What ``work(asked, part, words)`` makes of each part, in their order."""


def map_sites(
    cluster: Cluster,
    scene: SceneOrPath,
    sites: Iterable[Any],
    out: PathLike | Sequence[PathLike],
    batch: int | None,
    options: Mapping[str, object],
) -> Mapped:
    _checked(batch, None, options)
    origin, _, crs, options = _asked(scene, options)
    listed = named(_listed(sites, crs))
    name, n = Counter(site[3] for site in listed).most_common(1)[0]
    if n > 1:
        raise wrong("sites", f"{n} of the name {name!r}", "a name of its own for each", "E207")
    outputs = _outputs(out, ["{site}"])
    words = [*words_of({**options, "resume": True}), *files_of(outputs)]
    size = batch or _size_of_part(scene, listed, words)
    parts = [listed[first : first + size] for first in range(0, len(listed), size)]
    done = cluster.run("map_sites", map_some, _shared(cluster, origin), parts, words)
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
    origin, grid, crs, options = _asked(scene, options)
    listed = named(_listed(uavs, crs))
    outputs = _outputs(out, ["{row}", "{col}"])
    words = [*words_of({**options, "tile_size": tile_size, "resume": True}), *files_of(outputs)]
    tiles, size = tiles_of(grid, tile_size), batch or _tiles_of_part(grid, tile_size, listed, options)
    of_part = [tiles[first : first + size] for first in range(0, len(tiles), size)]
    places = places_of(listed)
    parts = [(part, near(part, (grid, tile_size), (listed, places), options)) for part in of_part]
    done = cluster.run("map_tiles", map_some_tiles, _shared(cluster, origin), parts, words)
    return _told(done, "tiles", len(tiles))


def p_los(
    cluster: Cluster, scene: SceneOrPath, uavs: Iterable[Any], batch: int | None, sight: Mapping[str, object]
) -> npt.NDArray[np.float64]:
    if not isinstance(scene, Scene):
        raise wrong("scene", repr(scene), "a Scene")
    _checked(batch, None, {})
    listed = _listed(uavs, scene.crs)
    words = words_of(sight)
    size = batch or _size_of_part(scene, listed, words)
    parts = [listed[first : first + size] for first in range(0, len(listed), size)]
    counted = cluster.run("p_los", p_los_of_some, _shared(cluster, scene._origin or scene), parts, words)
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
    origin, _, _, options = _asked(scene, options)
    n = batch or 8
    words = words_of({**options, "height": height})
    parts = [(k + 1, n) for k in range(n)]
    tables: list[list[dict[str, str]]] = cluster.run("place", rank_some, _shared(cluster, origin), parts, words)
    # Of equal shares the first in the order of the candidates, as in one run.
    rows = [row for table in tables for row in table]
    if not rows:
        raise Error("no candidate is left", "E209")
    rows.sort(key=lambda row: -float(row["p_los"] or "-1"))
    return [{**row, "rank": str(k + 1)} for k, row in enumerate(rows)]


# What the driver knows.


def _asked(scene: SceneOrPath, options: Mapping[str, object]) -> tuple[Asked, Grid, str | None, dict[str, object]]:
    """What processes open, where its cells lie, its reference system, and the options that do not say how it is read."""
    if isinstance(scene, Scene):
        return scene._origin or scene, Grid(*scene._scene.place), scene.crs, dict(options)
    reading = {name: value for name, value in options.items() if name in READING}
    others = {name: value for name, value in options.items() if name not in READING}
    origin = origin_of(scene, reading)
    found = _skyshed.raster_grid(origin.word, origin.words)
    if found is None:
        opened = opened_once(origin)
        return origin, Grid(*opened._scene.place), opened.crs, others
    shape, place, crs = found
    return origin, Grid(shape, place, crs), crs[0] if crs else None, others


def _shared(cluster: Cluster, asked: Asked) -> Any:
    return asked if isinstance(asked, Origin) else cluster.share(asked)


def named(uavs: list[AskedUav]) -> list[AskedUav]:
    """UAVs that all have names: those of the program."""
    return [(x, y, h, id if id is not None else str(k + 1), antenna) for k, (x, y, h, id, antenna) in enumerate(uavs)]


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


#: Flags that say who is in range.
OF_RANGE = ("--radius", "--rx", "--receivers", "--min-radius", "--sector", "--elevation", "--beam")


def _size_of_part(scene: SceneOrPath, sites: list[AskedUav], words: list[str]) -> int:
    """Sites that take about two seconds, by what counting one takes here; files take as long again."""
    if not isinstance(scene, Scene):
        return min(20, max(len(sites) // 8, 1))
    start = time.perf_counter()
    try:
        scene._scene.p_los(sites[:1], [word for word in words if word.startswith(OF_RANGE)])
    except Error:
        return 1
    spent = 2 * (time.perf_counter() - start) + 1e-3
    return int(min(max(TASK_S / spent, 1), MOST_A_TASK, max(len(sites) // 8, 1)))


def tiles_of(grid: Grid, tile_size: int) -> list[Tile]:
    """Rows and columns of all tiles, row by row from the north-west."""
    n_rows, n_cols = (-(-n // tile_size) for n in grid.shape)
    return [(row, col) for row in range(n_rows) for col in range(n_cols)]


def _tiles_of_part(grid: Grid, tile_size: int, uavs: list[AskedUav], options: Mapping[str, object]) -> int:
    """Tiles that take about two seconds, by the cells of a tile and those in range of a UAV."""
    radius = options.get("radius")
    cells, cell_area = min(tile_size**2, grid.shape[0] * grid.shape[1]), grid.place[1] * grid.place[3]
    disc = np.pi * float(radius) ** 2 / cell_area if isinstance(radius, (int, float)) else np.inf
    seen = min(disc, cells) * len(uavs) * min(1.0, (cells + disc) / (grid.shape[0] * grid.shape[1]))
    spent = 1e-9 * (CELL_NS * cells + SEEN_NS * seen)
    n_tiles = len(tiles_of(grid, tile_size))
    return int(min(max(TASK_S / spent, 1), MOST_A_TASK, max(n_tiles // 8, 1)))


def places_of(uavs: list[AskedUav]) -> npt.NDArray[np.float64]:
    """East and north of each."""
    return np.array([uav[:2] for uav in uavs], dtype=float)


def near(
    tiles: list[Tile],
    cut: tuple[Grid, int],
    listed: tuple[list[AskedUav], npt.NDArray[np.float64]],
    options: Mapping[str, object],
) -> list[AskedUav]:
    """The UAVs that may have a cell of some tiles in range; all of them where a layer tells their places in the list."""
    (grid, tile_size), (uavs, places) = cut, listed
    radius, layers = options.get("radius"), options.get("layers") or ()
    names = layers.split(",") if isinstance(layers, str) else list(layers)  # type: ignore[call-overload]
    if not isinstance(radius, (int, float)) or any(name in NUMBERED for name in names):
        return uavs
    west, width, north, height = grid.place
    rows, cols = [row for row, _ in tiles], [col for _, col in tiles]
    # A unit of the reference system may be a foot: twice the radius and a cell are enough.
    reach_x, reach_y = 4 * radius + 2 * width, 4 * radius + 2 * height
    x0, x1 = west + min(cols) * tile_size * width - reach_x, west + (max(cols) + 1) * tile_size * width + reach_x
    y1, y0 = north - min(rows) * tile_size * height + reach_y, north - (max(rows) + 1) * tile_size * height - reach_y
    # A table without rows is no table: the program leaves out who is too far.
    inside = (x0 <= places[:, 0]) & (places[:, 0] <= x1) & (y0 <= places[:, 1]) & (places[:, 1] <= y1)
    return [uavs[k] for k in np.flatnonzero(inside)] or uavs[:1]


# What a process does.


def prepare(threads: int | None, memory: int | None) -> None:
    """Keeps to what a process may take: its threads, and its memory [bytes], beyond which work is refused before it begins."""
    if threads:
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))
    if memory:
        _skyshed.limit_memory(int(0.95 * memory))


def p_los_of_some(asked: Asked, sites: list[AskedUav], words: list[str]) -> npt.NDArray[np.float64]:
    scene = opened_once(asked) if isinstance(asked, Origin) else asked
    return scene._scene.p_los(sites, words)


def map_some(asked: Asked, sites: list[AskedUav], words: list[str]) -> tuple[Mapped, list[tuple[str, Error]]]:
    """Files of some sites; those that fail are told one by one."""
    try:
        return _map(asked, sites, words), []
    except (Error, OSError):
        return _one_by_one((str(site[3]), lambda site=site: _map(asked, [site], words)) for site in sites)  # type: ignore[misc]


def map_some_tiles(
    asked: Asked, part: tuple[list[Tile], list[AskedUav]], words: list[str]
) -> tuple[Mapped, list[tuple[str, Error]]]:
    """Files of some tiles; those that fail are told one by one."""
    tiles, uavs = part
    own = {tile: [*words, f"--tile={tile[0]},{tile[1]}"] for tile in tiles}
    try:
        return _map(asked, uavs, [*words, *(said[-1] for said in own.values())]), []
    except (Error, OSError):
        return _one_by_one((f"tile {row},{col}", lambda said=said: _map(asked, uavs, said)) for (row, col), said in own.items())  # type: ignore[misc]


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


def _map(asked: Asked, uavs: list[AskedUav], words: list[str]) -> Mapped:
    with tempfile.TemporaryDirectory(prefix="skyshed-") as folder:
        counts = json.loads(ask_map(asked, uavs, words, folder).document)
    return Mapped(counts["mapped"], counts["there"])


def ask_map(asked: Asked, uavs: list[AskedUav], words: list[str], folder: str) -> _skyshed.Found:
    """Asks for a map; of a raster file no more is read than it needs."""
    path = os.path.join(folder, "sites.csv")
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(table_of(uavs))
    word, of_scene = (asked.word, asked.words) if isinstance(asked, Origin) else ("memory", [])
    line = ["map", word, *of_scene, f"--uavs={path}", *words]
    if isinstance(asked, Origin) and _skyshed.raster_grid(word, of_scene) is not None:
        return _skyshed.ask(line)
    scene = opened_once(asked) if isinstance(asked, Origin) else asked
    return scene._scene.ask(line)


def rank_some(asked: Asked, part: tuple[int, int], words: list[str]) -> list[dict[str, str]]:
    """The ranks of a part of the candidates."""
    scene = opened_once(asked) if isinstance(asked, Origin) else asked
    word, of_scene = (asked.word, asked.words) if isinstance(asked, Origin) else ("memory", [])
    try:
        found = scene._scene.ask(["place", word, *of_scene, *words, f"--shard={part[0]}/{part[1]}"])
    except Error as error:
        # Others may have some.
        if error.code == "E209":
            return []
        raise
    header, *rows = found.table
    named = (dict(zip(header, row)) for row in rows)
    return [row for row in named if row["kind"] == "candidate"]

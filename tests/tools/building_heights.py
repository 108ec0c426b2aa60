"""What buildings a GeoJSON file means, told from the definitions alone: heights above the ground of cells, as JSON.

    python building_heights.py FILE N CELL LIST PARTS < nothing > rows from the north

N × N cells of CELL meters from 0, 0. LIST is that of --missing, PARTS that of --parts. Needs shapely.
"""

import json
import math
import sys

from shapely.geometry import Point, shape
from shapely.ops import unary_union
from shapely.prepared import prep

OSM = {"yes", "house", "apartments", "garage", "retail", "church", "no", "construction"}
STOREYS = ["building:levels", "num_floors", "storeysAboveGround", "numberOfFloorsAboveGround"]


def number(value):
    """A number of meters, or None where that is none."""
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, (int, float)):
        return float(value) if math.isfinite(value) else None
    text = str(value).strip()
    for unit, meters in (("ft", 0.3048), ("m", 1.0)):
        if text.endswith(unit):
            inner = number(text[: -len(unit)].strip())
            return None if inner is None else inner * meters
    try:
        found = float(text)
    except ValueError:
        return None
    return found if math.isfinite(found) else None


class Thing:
    def __init__(self, k, feature):
        self.tags = dict(feature["properties"] or {})
        for name, value in self.tags.pop("tags", {}).items():
            self.tags.setdefault(name, value)
        self.id = str(feature.get("id", self.tags.get("id", k + 1)))
        self.area = shape(feature["geometry"])
        h = number(self.tags.get("height"))
        if h is not None and h < 0 and "min_height" not in self.tags:
            h = None
        self.height = h
        self.storeys = None
        for name in STOREYS:
            n = number(self.tags.get(name))
            if n is not None and n > 0:
                self.storeys = n + max(number(self.tags.get("roof:levels")) or 0, 0)
                break
        self.named = self.tags.get("building_id")
        self.is_part = self.named is not None or self.tags.get("building:part") not in (None, "", "no")
        self.parts = []
        self.outline = None
        self.building = None

    def word(self, name):
        value = self.tags.get(name)
        return str(value).strip().lower() if value not in (None, "") else None


def is_there(thing, has_tags):
    if thing.word("location") == "underground" or thing.word("is_underground") in ("true", "yes", "1"):
        return False
    if thing.word("building") in ("no", "demolished") or thing.height == 0:
        return False
    if thing.word("building") or thing.word("building:part") not in (None, "no"):
        return True
    lives = ("demolished:", "razed:", "removed:", "proposed:", "construction:")
    if any(name == life + "building" for name in thing.tags for life in lives):
        return False
    is_other = any(thing.word(key) for key in ("leisure", "landuse", "natural", "barrier", "highway"))
    return not (has_tags and (is_other or (thing.word("amenity") and thing.height is None)))


def read_heights(things, outlines, parts_rule):
    """One height for each building that has any: its outline's, else that of its highest part."""
    if parts_rule == "join":
        return [thing.height for thing in (outlines or things) if thing.height is not None and thing.height > 0]
    found, undrawn = [], {}
    for thing in things:
        own = [thing.height] if thing.height is not None and thing.height > 0 else []
        if not thing.is_part:
            of_parts = [part.height for part in thing.parts if (part.height or 0) > 0]
            found += own or ([max(of_parts)] if of_parts else [])
        elif thing.outline is None and thing.building is None:
            found += own
        elif thing.outline is None and not isinstance(thing.building, Thing):
            undrawn[thing.building] = max([undrawn.get(thing.building, 0)] + own)
    return found + [height for height in undrawn.values() if height > 0]


def main():
    file, n, cell, words, parts_rule = sys.argv[1:]
    n, cell, words = int(n), float(cell), words.split(",")
    with open(file, encoding="utf-8") as text:
        things = [Thing(k, feature) for k, feature in enumerate(json.load(text)["features"])]
    named = [thing.word("building") for thing in things if thing.word("building")]
    known = [word for word in named if word in OSM]
    has_tags = bool(known) and 2 * len(known) >= len(named) or not known and any(t.word("building:part") for t in things)
    things = [thing for thing in things if is_there(thing, has_tags)]
    outlines = [thing for thing in things if not thing.is_part]
    for part in (thing for thing in things if thing.is_part):
        named = [thing for thing in outlines if part.named is not None and thing.id == str(part.named)][:1]
        holding = [thing for thing in outlines if 2 * thing.area.intersection(part.area).area > part.area.area]
        found = named or sorted(holding, key=lambda thing: thing.area.area)[:1]
        part.building = found[0] if found else part.named
        # A part beside its building takes nothing of it.
        if found and found[0].area.intersection(part.area).area > 1e-9:
            part.outline = found[0]
            found[0].parts.append(part)
    known = sorted(read_heights(things, outlines, parts_rule))
    median = known[(len(known) - 1) // 2] if known else None

    def height_of(thing):
        if thing.height is not None:
            return thing.height
        if thing.is_part:
            own = thing.storeys or (thing.outline.storeys if thing.outline and parts_rule == "replace" else None)
            if own:
                return 3.0 * own
        for word in words:
            if word == "levels" and thing.storeys:
                return 3.0 * thing.storeys
            if word == "median" and median is not None:
                return median
            if word not in ("levels", "median", "drop", "fail"):
                return float(word)
        return None

    solids = []
    for thing in things:
        own = height_of(thing)
        tops = [(part, height_of(part)) for part in thing.parts]
        tops = [(part, top) for part, top in tops if top is not None]
        if parts_rule == "join" or not tops:
            solids.append((thing.area, own))
            continue
        rest = thing.area.difference(unary_union([part.area for part, _ in tops]))
        if 10 * rest.area <= thing.area.area:
            continue
        lowest, highest = min(top for _, top in tops), max(top for _, top in tops)
        # A height that was made up is none of its own.
        solids.append((rest, own if thing.height is not None and own < highest else lowest))
    grid = [[0.0] * n for _ in range(n)]
    for area, top in solids:
        if top is None or area.is_empty:
            continue
        west, south, east, north = area.bounds
        inside = prep(area)
        for row in range(n):
            y = (n - row - 0.5) * cell
            for col in range(n):
                x = (col + 0.5) * cell
                if west <= x <= east and south <= y <= north and inside.contains(Point(x, y)):
                    grid[row][col] = max(grid[row][col], top)
    print(json.dumps(grid))


main()

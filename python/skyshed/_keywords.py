"""Keywords of the questions, with their types: made from the requests of the program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from skyshed._options import PathLike


class AnySceneKeywords(TypedDict, total=False):
    """Reading of any scene."""

    #: Flat ground at this height above the datum [m], or `buildings`
    ground: float | str | Sequence[float | str] | None

    #: A cell whose surface is more than this above the ground is a building [m]
    building_threshold: float | None

    #: Property of a footprint's height above ground; default `height`
    height_field: str | None

    #: Property that holds the height of a footprint's top above the datum, instead
    top_field: str | None

    #: Unit of heights of footprints that name none
    height_unit: Literal["m", "ft"] | None

    #: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`;
    base_field: str | None

    #: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of
    levels_field: str | None

    #: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    height_error_field: str | None

    #: Roofs of CityJSON, or of a mesh, which is read as buildings then
    roofs: Literal["flat", "lod2"] | None

    #: Table of a GeoPackage, where it has several
    layer: str | None

    #: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    missing: float | str | Sequence[float | str] | None

    #: Outlines of buildings that are drawn by parts as well
    parts: Literal["replace", "join"] | None

    #: Terrain cell below a footprint that its height is above
    base: Literal["lowest", "mean", "highest"] | None

    #: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    data_area: float | str | Sequence[float | str] | None

    #: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    extent: Sequence[float] | None

    #: Cell size, of a raster its own [m]; default 1
    cell: float | None

    #: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web
    project: object | None

    #: Effect of nodata cells on links
    nodata_as: Literal["block", "clear"] | None

    #: Hash inputs above 64 MB too
    hash: bool | None


class FootprintKeywords(AnySceneKeywords, total=False):
    """Reading of footprints in memory."""

    #: Terrain model below the surface model or the footprints
    terrain: PathLike | None


class SceneKeywords(FootprintKeywords, total=False):
    """Reading of a file: the options under *Scene* of ``skyshed map --help``."""

    #: Coordinate reference system of the scene, where its files name none or a wrong one
    crs: object | None

    #: Band of a raster that holds its heights, by number from 1 or by name
    band: float | str | Sequence[float | str] | None


class SightKeywords(TypedDict, total=False):
    """Receivers, range, antennas and earth."""

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Cells that hold receivers: ground, street, roof, all …
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None

    #: Largest horizontal distance from the UAV to a receiver [m]
    radius: float | None

    #: Engine; auto is the fastest exact one
    method: float | str | Sequence[float | str] | None

    #: Least horizontal distance from the UAV to a receiver [m]
    min_radius: float | None

    #: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    sector: Sequence[float] | None

    #: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    elevation: Sequence[float] | None

    #: Full angle of a cone straight down with the receivers in range [deg]
    beam: float | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None


class MapKeywords(SightKeywords, total=False):
    """Question of maps."""

    #: Standard deviation of the error of each building's height [m]; default 0
    height_error: float | None

    #: Standard deviation of an error that all heights of buildings share [m]; default 0
    height_bias: float | None

    #: Standard deviations that heights are within for the layer `sure`
    sigma: float | None

    #: Largest error of the P_LoS of any UAV, such as 0.005: makes the map on the coarsest cells that keep it
    tolerance: float | None

    #: Layers to make, separated by commas; pictures show the first
    layers: Literal["los", "margin", "least-receiver-height", "least-height", "stability", "sure", "p-los", "count", "which", "union", "best-server"] | Sequence[Literal["los", "margin", "least-receiver-height", "least-height", "stability", "sure", "p-los", "count", "which", "union", "best-server"]] | str | None

    #: Count receivers by zone too (street, crossroad, courtyard, rooftop) in the table and the document: finding zones costs
    zones: bool | None


class SaveKeywords(TypedDict, total=False):
    """Files of a map."""

    #: PNG with one pixel per cell, a world file and a .prj, instead of a picture
    bare: bool | None

    #: Arrangement of the cells in .tif files
    tif_layout: Literal["cog", "plain"] | None

    #: Mask of one UAV in .tif and .bil files as `gdal_viewshed` writes it: 255 in line of sight, 0 everywhere else, also out
    gdal_values: bool | None

    #: Coverage as polygons in .geojson and .fgb files, one per connected part of a class and site, holes kept
    polygons: Literal["los", "nlos", "all"] | None

    #: Largest distance of an outline of the polygons from the cell edges [m]; each stays valid, neighbors may overlap by as
    simplify: float | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None


class LinkKeywords(TypedDict, total=False):
    """Question of one link."""

    #: Refuse a receiver that is farther away [m]
    radius: float | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class TrackKeywords(TypedDict, total=False):
    """Question of a track."""

    #: Longest step along the track between two decided places [m]; what begins and ends within a step is missed
    every: float | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class LimitsKeywords(TypedDict, total=False):
    """Question of limits."""

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Cells that hold receivers: ground, street, roof, all …
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None

    #: Largest horizontal distance from the UAV to a receiver [m]
    radius: float | None

    #: Engine; auto is the fastest exact one
    method: float | str | Sequence[float | str] | None

    #: Least horizontal distance from the UAV to a receiver [m]
    min_radius: float | None

    #: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    sector: Sequence[float] | None

    #: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    elevation: Sequence[float] | None

    #: Full angle of a cone straight down with the receivers in range [deg]
    beam: float | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Distance of the UAV from where it should be, sideways and in height [m]
    uav_error: float | None

    #: Error of the heights of all buildings [m]
    height_error: float | None

    #: Other cities of a generated kind that tell how much one city of many matters
    cities: int | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None


class CompareKeywords(TypedDict, total=False):
    """Question of placements side by side."""

    #: Edge of the blocks of ground that are resampled for intervals [m]
    block: float | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Cells that hold receivers: ground, street, roof, all …
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None

    #: Largest horizontal distance from the UAV to a receiver [m]
    radius: float | None

    #: Engine; auto is the fastest exact one
    method: float | str | Sequence[float | str] | None

    #: Least horizontal distance from the UAV to a receiver [m]
    min_radius: float | None

    #: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    sector: Sequence[float] | None

    #: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    elevation: Sequence[float] | None

    #: Full angle of a cone straight down with the receivers in range [deg]
    beam: float | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Standard deviation of the error of each building's height [m]; default 0
    height_error: float | None

    #: Standard deviation of an error that all heights of buildings share [m]; default 0
    height_bias: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class ZonesKeywords(TypedDict, total=False):
    """Picture of zones."""

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class CityKeywords(TypedDict, total=False):
    """Files of a city."""

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class PlaceKeywords(TypedDict, total=False):
    """Question of where to hover."""

    #: Distance between candidate places: the centers of square cells over the scene [m]
    step: float | None

    #: Only candidates over these zones, separated by commas
    over: Literal["street", "crossroad", "courtyard", "rooftop"] | Sequence[Literal["street", "crossroad", "courtyard", "rooftop"]] | str | None

    #: Leave out rows of the candidates that cannot be read, with a warning that names them
    skip_bad: bool | None

    #: Only the K-th of N nearly equal parts of the candidates, in their order; nothing is refined: for schedulers that hand out
    shard: float | str | Sequence[float | str] | None

    #: At least so high above the roof or ground directly below [m]
    clearance: float | None

    #: Quantity to make large, such as p_los, p_los(street), margin, p_los>=0.8
    goal: float | str | Sequence[float | str] | None

    #: Raster of scores for the goal p_los(weights): each receiver counts the whole value of the cell that holds it
    weights: PathLike | None

    #: Instead of the largest share, the least height that reaches the share of the goal
    minimize: Literal["height"] | None

    #: Number of UAVs that are to see most together, of all receivers of the goal whatever the radius
    count: int | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Cells that hold receivers: ground, street, roof, all …
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None

    #: Largest horizontal distance from the UAV to a receiver [m]
    radius: float | None

    #: Engine; auto is the fastest exact one
    method: float | str | Sequence[float | str] | None

    #: Least horizontal distance from the UAV to a receiver [m]
    min_radius: float | None

    #: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    sector: Sequence[float] | None

    #: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    elevation: Sequence[float] | None

    #: Full angle of a cone straight down with the receivers in range [deg]
    beam: float | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Standard deviation of the error of each building's height [m]; default 0
    height_error: float | None

    #: Standard deviation of an error that all heights of buildings share [m]; default 0
    height_bias: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: View of the winner, or of those chosen together: a coverage map (.png .svg .pdf .tif)
    map: PathLike | None

    #: Ranks that documents and points list
    top: int | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class SampleKeywords(TypedDict, total=False):
    """Samples of placements."""

    #: Placements stand over the middles of a generated city's crossroads, streets and buildings
    centers: bool | None

    #: Generated cities to sample, from `seed` on; intervals are over cities
    cities: int | None

    #: Confidence of the intervals
    ci: float | None

    #: Edge of the blocks of ground that are resampled for the intervals over one city [m]; default: an eighth of the
    block: float | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Cells that hold receivers: ground, street, roof, all …
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None

    #: Largest horizontal distance from the UAV to a receiver [m]
    radius: float | None

    #: Engine; auto is the fastest exact one
    method: float | str | Sequence[float | str] | None

    #: Least horizontal distance from the UAV to a receiver [m]
    min_radius: float | None

    #: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    sector: Sequence[float] | None

    #: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    elevation: Sequence[float] | None

    #: Full angle of a cone straight down with the receivers in range [deg]
    beam: float | None

    #: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    earth_k: float | str | None

    #: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    curvature_coefficient: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None


class InfoKeywords(TypedDict, total=False):
    """Facts of a file."""

    #: Terrain model below the surface model or the footprints
    terrain: PathLike | None

    #: Flat ground at this height above the datum [m], or `buildings`
    ground: float | str | Sequence[float | str] | None

    #: A cell whose surface is more than this above the ground is a building [m]
    building_threshold: float | None

    #: Property of a footprint's height above ground; default `height`
    height_field: str | None

    #: Property that holds the height of a footprint's top above the datum, instead
    top_field: str | None

    #: Unit of heights of footprints that name none
    height_unit: Literal["m", "ft"] | None

    #: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`;
    base_field: str | None

    #: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of
    levels_field: str | None

    #: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    height_error_field: str | None

    #: Roofs of CityJSON, or of a mesh, which is read as buildings then
    roofs: Literal["flat", "lod2"] | None

    #: Table of a GeoPackage, where it has several
    layer: str | None

    #: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    missing: float | str | Sequence[float | str] | None

    #: Outlines of buildings that are drawn by parts as well
    parts: Literal["replace", "join"] | None

    #: Terrain cell below a footprint that its height is above
    base: Literal["lowest", "mean", "highest"] | None

    #: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    data_area: float | str | Sequence[float | str] | None

    #: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    extent: Sequence[float] | None

    #: Cell size, of a raster its own [m]; default 1
    cell: float | None

    #: Coordinate reference system of the scene, where its files name none or a wrong one
    crs: object | None

    #: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web
    project: object | None

    #: Edge length of a generated city [m]
    size: float | None

    #: Seed of everything random
    seed: int | None

    #: Effect of nodata cells on links
    nodata_as: Literal["block", "clear"] | None

    #: Band of a raster that holds its heights, by number from 1 or by name
    band: float | str | Sequence[float | str] | None

    #: Hash inputs above 64 MB too
    hash: bool | None

    #: Also α, β and γ of squares of this size, from the north-west corner [m]
    tile: float | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None


class PlosKeywords(TypedDict, total=False):
    """Question of P_LoS over whole cities."""

    #: Methods, separated by commas: product, city, geometry, maps, ids of models such as itu, models, all
    method: str | Sequence[str] | None

    #: A curve of your own: a table with the columns theta_deg (or distance_m) and p_los, `NAME=-` from standard input;
    curve: PathLike | Sequence[PathLike] | None

    #: Leave out rows of the curves that cannot be read, with a warning that names them
    skip_bad: bool | None

    #: Elevation angles of the UAV [deg]: A:B:S with both ends, or a list; default 5:90:5
    theta: float | str | Sequence[float | str] | None

    #: Ground distances of the users [m], instead of elevation angles
    distance: float | str | Sequence[float | str] | None

    #: Users over the whole area within this radius of the UAV [m], instead of on a circle
    radius: float | str | Sequence[float | str] | None

    #: Azimuths [deg]: 0 across the user's street, 90 along it; default: the mean over all
    phi: float | str | Sequence[float | str] | None

    #: Values of α instead of the city's
    alpha: float | str | Sequence[float | str] | None

    #: Values of β instead of the city's [1/km²]
    beta: float | str | Sequence[float | str] | None

    #: Values of γ instead of the city's [m]
    gamma: float | str | Sequence[float | str] | None

    #: Users that count: outdoor, street, crossroad
    users: Literal["outdoor", "street", "crossroad"] | Sequence[Literal["outdoor", "street", "crossroad"]] | str | None

    #: Place of the UAV; several separated by commas
    placement: Literal["anywhere", "street", "crossroad", "rooftop", "street-center", "crossroad-center", "rooftop-center"] | Sequence[Literal["anywhere", "street", "crossroad", "rooftop", "street-center", "crossroad-center", "rooftop-center"]] | str | None

    #: Count only UAVs that are clear of the roof below them; otherwise one inside a building is NLoS to all
    uav_clear_of_roof: bool | None

    #: Height of the receivers above ground or roof [m]
    rx_height: float | str | None

    #: Stop when all intervals are ±P or narrower
    until: float | None

    #: Largest error of any P_LoS, such as 0.005, at the least effort
    tolerance: float | None

    #: Confidence of the intervals
    ci: float | None

    #: Cities that `city` draws
    cities: int | None

    #: Users on the circle, or in the area, of each city that `city` draws; with `phi` 8, one in each octant
    users_per_city: int | None

    #: Links that `geometry` draws for each value
    links: int | None

    #: UAV positions over a real city
    positions: int | None

    #: Over a real city P_LoS at an angle is that of users who see the UAV within so many degrees of it
    theta_band: float | None

    #: Edge of the blocks of a real city that are resampled for its intervals [m]; default: an eighth of the city, at
    block: float | None

    #: Terrain model below the surface model or the footprints
    terrain: PathLike | None

    #: Flat ground at this height above the datum [m], or `buildings`
    ground: float | str | Sequence[float | str] | None

    #: A cell whose surface is more than this above the ground is a building [m]
    building_threshold: float | None

    #: Property of a footprint's height above ground; default `height`
    height_field: str | None

    #: Property that holds the height of a footprint's top above the datum, instead
    top_field: str | None

    #: Unit of heights of footprints that name none
    height_unit: Literal["m", "ft"] | None

    #: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`;
    base_field: str | None

    #: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of
    levels_field: str | None

    #: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    height_error_field: str | None

    #: Roofs of CityJSON, or of a mesh, which is read as buildings then
    roofs: Literal["flat", "lod2"] | None

    #: Table of a GeoPackage, where it has several
    layer: str | None

    #: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    missing: float | str | Sequence[float | str] | None

    #: Outlines of buildings that are drawn by parts as well
    parts: Literal["replace", "join"] | None

    #: Terrain cell below a footprint that its height is above
    base: Literal["lowest", "mean", "highest"] | None

    #: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    data_area: float | str | Sequence[float | str] | None

    #: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    extent: Sequence[float] | None

    #: Cell size, of a raster its own [m]; default 1
    cell: float | None

    #: Coordinate reference system of the scene, where its files name none or a wrong one
    crs: object | None

    #: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web
    project: object | None

    #: Edge length of a generated city [m]
    size: float | None

    #: Seed of everything random
    seed: int | None

    #: Effect of nodata cells on links
    nodata_as: Literal["block", "clear"] | None

    #: Band of a raster that holds its heights, by number from 1 or by name
    band: float | str | Sequence[float | str] | None

    #: Hash inputs above 64 MB too
    hash: bool | None

    #: Replace files that exist
    overwrite: bool | None

    #: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    csv_text: bool | None

    #: Kind of plot
    plot: Literal["auto", "curves", "heat"] | None

    #: Title of the picture, or of the page
    title: str | None

    #: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    attribution: str | None

    #: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    width: int | None

    #: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    dpi: int | None

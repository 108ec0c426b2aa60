"""Keywords of the questions, with their types: made from the requests of the program."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from skyshed._options import PathLike


class AnySceneKeywords(TypedDict, total=False):
    """Reading of any scene.

    * ``ground``: Flat ground at this height above the datum [m], or `buildings`
    * ``building_threshold``: A cell whose surface is more than this above the ground is a building [m]
    * ``height_field``: Property of a footprint's height above ground; default `height`
    * ``top_field``: Property that holds the height of a footprint's top above the datum, instead
    * ``height_unit``: Unit of heights of footprints that name none
    * ``base_field``: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`; default the first there is of `b3_h_maaiveld`, `ground_height`, `z_ground`, `h_ground`, `ground`
    * ``levels_field``: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of `building:levels`, `num_floors`, `storeysAboveGround`, `numberOfFloorsAboveGround`
    * ``height_error_field``: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    * ``roofs``: Roofs of surfaces, as in CityJSON and CityGML, or of a mesh, which is read as buildings then
    * ``layer``: Table of a GeoPackage, where it has several
    * ``missing``: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    * ``parts``: Outlines of buildings that are drawn by parts as well
    * ``base``: Terrain cell below a footprint that its height is above
    * ``data_area``: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    * ``extent``: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    * ``cell``: Cell size, of a raster its own [m]; default 1
    * ``project``: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web Mercator; EPSG:n, or as `crs`. Of a raster each cell takes the height of the cell of the file that holds its center
    * ``swap_axes``: Exchange x and y of all positions of footprints, where the file has them in the other order than `info` says
    * ``nodata_as``: Effect of nodata cells on links
    * ``hash``: Hash inputs above 64 MB too
    """

    ground: float | str | Sequence[float | str] | None
    building_threshold: float | None
    height_field: str | None
    top_field: str | None
    height_unit: Literal["m", "ft"] | None
    base_field: str | None
    levels_field: str | None
    height_error_field: str | None
    roofs: Literal["flat", "lod2"] | None
    layer: str | None
    missing: float | str | Sequence[float | str] | None
    parts: Literal["replace", "join"] | None
    base: Literal["lowest", "mean", "highest"] | None
    data_area: float | str | Sequence[float | str] | None
    extent: Sequence[float] | None
    cell: float | None
    project: object | None
    swap_axes: bool | None
    nodata_as: Literal["block", "clear"] | None
    hash: bool | None


class FootprintKeywords(AnySceneKeywords, total=False):
    """Reading of footprints in memory.

    * ``terrain``: Terrain model below the surface model or the footprints

    And those of :class:`AnySceneKeywords`.
    """

    terrain: PathLike | None


class SceneKeywords(FootprintKeywords, total=False):
    """Reading of a file: the options under *Scene* of ``skyshed map --help``.

    * ``crs``: Coordinate reference system of the scene, where its files name none or a wrong one
    * ``band``: Band of a raster that holds its heights, by number from 1 or by name

    And those of :class:`FootprintKeywords`.
    """

    crs: object | None
    band: float | str | Sequence[float | str] | None


class SightKeywords(TypedDict, total=False):
    """Receivers, range, antennas and earth.

    * ``rx_height``: Height of the receivers above ground or roof [m]
    * ``receivers``: Cells that hold receivers: ground, street, roof, all …
    * ``radius``: Largest horizontal distance from the UAV to a receiver [m]
    * ``method``: Engine; auto is the fastest exact one
    * ``min_radius``: Least horizontal distance from the UAV to a receiver [m]
    * ``sector``: Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    * ``elevation``: Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    * ``beam``: Full angle of a cone straight down with the receivers in range [deg]
    * ``slant_range``: Largest distance in space from the UAV to a receiver [m]
    * ``earth_k``: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    * ``curvature_coefficient``: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    """

    rx_height: float | str | None
    receivers: Literal["ground", "street", "crossroad", "courtyard", "roof", "all", "air"] | None
    radius: float | None
    method: float | str | Sequence[float | str] | None
    min_radius: float | None
    sector: Sequence[float] | None
    elevation: Sequence[float] | None
    beam: float | None
    slant_range: float | None
    earth_k: float | str | None
    curvature_coefficient: float | None


class MapKeywords(SightKeywords, total=False):
    """Question of maps.

    * ``height_error``: Standard deviation of the error of each building's height [m]; default 0
    * ``height_bias``: Standard deviation of an error that all heights of buildings share [m]; default 0
    * ``sigma``: Standard deviations that heights are within for the layer `sure`
    * ``tolerance``: Largest error of the P_LoS of any UAV, such as 0.005: makes the map on the coarsest cells that keep it
    * ``layers``: Layers to make, separated by commas; pictures show the first
    * ``zones``: Count receivers by zone too (street, crossroad, courtyard, rooftop) in the table and the document: finding zones costs as much as a map or more

    And those of :class:`SightKeywords`.
    """

    height_error: float | None
    height_bias: float | None
    sigma: float | None
    tolerance: float | None
    layers: Literal["los", "margin", "least-receiver-height", "least-height", "stability", "sure", "p-los", "count", "which", "union", "all", "best-server", "uptime", "gap"] | Sequence[Literal["los", "margin", "least-receiver-height", "least-height", "stability", "sure", "p-los", "count", "which", "union", "all", "best-server", "uptime", "gap"]] | str | None
    zones: bool | None


class SaveKeywords(TypedDict, total=False):
    """Files of a map.

    * ``bare``: PNG with one pixel per cell, a world file and a .prj, instead of a picture
    * ``tif_layout``: Arrangement of the cells in .tif files
    * ``gdal_values``: Mask of one UAV in .tif and .bil files as `gdal_viewshed` writes it: 255 in line of sight, 0 everywhere else, also out of range, and no nodata
    * ``polygons``: Coverage as polygons in .geojson and .fgb files, one per connected part of a class and site, holes kept
    * ``simplify``: Largest distance of an outline of the polygons from the cell edges [m]; each stays valid, neighbors may overlap by as much
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    """

    bare: bool | None
    tif_layout: Literal["cog", "plain"] | None
    gdal_values: bool | None
    polygons: Literal["los", "nlos", "all"] | None
    simplify: float | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None
    overwrite: bool | None
    csv_text: bool | None


class LinkKeywords(TypedDict, total=False):
    """Question of one link.

    * ``radius``: Refuse a receiver that is farther away [m]; of many, leave its link without an answer
    * ``rx_height``: Height of the receivers above ground or roof [m]
    * ``earth_k``: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    * ``curvature_coefficient``: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    """

    radius: float | None
    rx_height: float | str | None
    earth_k: float | str | None
    curvature_coefficient: float | None
    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class TrackKeywords(TypedDict, total=False):
    """Question of a walk or a flight.

    * ``bad_uavs``: UAVs inside a building or below the ground: refuse them, leave them out, or lift them to the top of what is there
    * ``follow_ground``: Cut legs between heights above the ground at --every, to follow it
    * ``every``: Longest step between two places in tables and pictures [m]; over a curved earth what begins and ends within one is missed
    * ``stretches``: File of stretches, leg by leg: .csv .geojson .gpx .kml; repeat for more
    * ``rx_height``: Height of the receivers above ground or roof [m]
    * ``earth_k``: Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    * ``curvature_coefficient``: 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    """

    bad_uavs: Literal["fail", "skip", "lift"] | None
    follow_ground: bool | None
    every: float | None
    stretches: PathLike | Sequence[PathLike] | None
    rx_height: float | str | None
    earth_k: float | str | None
    curvature_coefficient: float | None
    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class LimitsKeywords(SightKeywords, total=False):
    """Question of limits.

    * ``bad_uavs``: UAVs inside a building or below the ground: refuse them, leave them out, or lift them to the top of what is there
    * ``uav_error``: Distance of the UAV from where it should be, sideways and in height [m]
    * ``height_error``: Error of the heights of all buildings [m]
    * ``cities``: Other cities of a generated kind that tell how much one city of many matters
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)

    And those of :class:`SightKeywords`.
    """

    bad_uavs: Literal["fail", "skip", "lift"] | None
    uav_error: float | None
    height_error: float | None
    cities: int | None
    overwrite: bool | None
    csv_text: bool | None


class CompareKeywords(SightKeywords, total=False):
    """Question of placements side by side.

    * ``bad_uavs``: UAVs inside a building or below the ground: refuse them, leave them out, or lift them to the top of what is there
    * ``block``: Edge of the blocks of ground that are resampled for intervals [m]
    * ``height_error``: Standard deviation of the error of each building's height [m]; default 0
    * ``height_bias``: Standard deviation of an error that all heights of buildings share [m]; default 0
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200

    And those of :class:`SightKeywords`.
    """

    bad_uavs: Literal["fail", "skip", "lift"] | None
    block: float | None
    height_error: float | None
    height_bias: float | None
    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class ZonesKeywords(TypedDict, total=False):
    """Picture of zones.

    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    """

    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class CityKeywords(TypedDict, total=False):
    """Files of a city.

    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    """

    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class PlaceKeywords(SightKeywords, total=False):
    """Question of where to hover.

    * ``step``: Distance between candidate places: the centers of square cells over the scene [m]
    * ``over``: Only candidates over these zones, separated by commas
    * ``skip_bad``: Leave out rows of the candidates that cannot be read, with a warning that names them
    * ``shard``: Only the K-th of N nearly equal parts of the candidates, in their order; nothing is refined: for schedulers that hand out numbers
    * ``clearance``: At least so high above the roof or ground directly below [m]
    * ``goal``: Quantity to make large, such as p_los, p_los(street), margin, p_los>=0.8
    * ``weights``: Raster of scores for the goal p_los(weights): each receiver counts the whole value of the cell that holds it
    * ``minimize``: Instead of the largest share, the least height that reaches the share of the goal
    * ``count``: Number of UAVs that are to see most together, of all receivers of the goal whatever the radius
    * ``height_error``: Standard deviation of the error of each building's height [m]; default 0
    * ``height_bias``: Standard deviation of an error that all heights of buildings share [m]; default 0
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``map``: View of the winner, or of those chosen together: a coverage map (.png .svg .pdf .tif)
    * ``top``: Ranks that documents and points list
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200

    And those of :class:`SightKeywords`.
    """

    step: float | None
    over: Literal["street", "crossroad", "courtyard", "rooftop"] | Sequence[Literal["street", "crossroad", "courtyard", "rooftop"]] | str | None
    skip_bad: bool | None
    shard: float | str | Sequence[float | str] | None
    clearance: float | None
    goal: float | str | Sequence[float | str] | None
    weights: PathLike | None
    minimize: Literal["height"] | None
    count: int | None
    height_error: float | None
    height_bias: float | None
    overwrite: bool | None
    csv_text: bool | None
    map: PathLike | None
    top: int | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class SampleKeywords(SightKeywords, total=False):
    """Samples of placements.

    * ``centers``: Placements stand over the middles of a generated city's crossroads, streets and buildings
    * ``cities``: Generated cities to sample, from `seed` on; intervals are over cities
    * ``ci``: Confidence of the intervals
    * ``block``: Edge of the blocks of ground that are resampled for the intervals over one city [m]; default: an eighth of the city, at least 100 m
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200

    And those of :class:`SightKeywords`.
    """

    centers: bool | None
    cities: int | None
    ci: float | None
    block: float | None
    overwrite: bool | None
    csv_text: bool | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None


class InfoKeywords(TypedDict, total=False):
    """Facts of a file.

    * ``terrain``: Terrain model below the surface model or the footprints
    * ``ground``: Flat ground at this height above the datum [m], or `buildings`
    * ``building_threshold``: A cell whose surface is more than this above the ground is a building [m]
    * ``height_field``: Property of a footprint's height above ground; default `height`
    * ``top_field``: Property that holds the height of a footprint's top above the datum, instead
    * ``height_unit``: Unit of heights of footprints that name none
    * ``base_field``: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`; default the first there is of `b3_h_maaiveld`, `ground_height`, `z_ground`, `h_ground`, `ground`
    * ``levels_field``: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of `building:levels`, `num_floors`, `storeysAboveGround`, `numberOfFloorsAboveGround`
    * ``height_error_field``: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    * ``roofs``: Roofs of surfaces, as in CityJSON and CityGML, or of a mesh, which is read as buildings then
    * ``layer``: Table of a GeoPackage, where it has several
    * ``missing``: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    * ``parts``: Outlines of buildings that are drawn by parts as well
    * ``base``: Terrain cell below a footprint that its height is above
    * ``data_area``: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    * ``extent``: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    * ``cell``: Cell size, of a raster its own [m]; default 1
    * ``crs``: Coordinate reference system of the scene, where its files name none or a wrong one
    * ``project``: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web Mercator; EPSG:n, or as `crs`. Of a raster each cell takes the height of the cell of the file that holds its center
    * ``swap_axes``: Exchange x and y of all positions of footprints, where the file has them in the other order than `info` says
    * ``size``: Edge length of a generated city [m]
    * ``seed``: Seed of everything random
    * ``nodata_as``: Effect of nodata cells on links
    * ``band``: Band of a raster that holds its heights, by number from 1 or by name
    * ``hash``: Hash inputs above 64 MB too
    * ``tile``: Also α, β and γ of squares of this size, from the north-west corner [m]
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    """

    terrain: PathLike | None
    ground: float | str | Sequence[float | str] | None
    building_threshold: float | None
    height_field: str | None
    top_field: str | None
    height_unit: Literal["m", "ft"] | None
    base_field: str | None
    levels_field: str | None
    height_error_field: str | None
    roofs: Literal["flat", "lod2"] | None
    layer: str | None
    missing: float | str | Sequence[float | str] | None
    parts: Literal["replace", "join"] | None
    base: Literal["lowest", "mean", "highest"] | None
    data_area: float | str | Sequence[float | str] | None
    extent: Sequence[float] | None
    cell: float | None
    crs: object | None
    project: object | None
    swap_axes: bool | None
    size: float | None
    seed: int | None
    nodata_as: Literal["block", "clear"] | None
    band: float | str | Sequence[float | str] | None
    hash: bool | None
    tile: float | None
    overwrite: bool | None
    csv_text: bool | None


class PlosKeywords(TypedDict, total=False):
    """Question of P_LoS over whole cities.

    * ``method``: Methods, separated by commas: product, city, geometry, maps, ids of models such as itu, models, all
    * ``curve``: A curve of your own: a table with the columns theta_deg (or distance_m) and p_los, `NAME=-` from standard input; repeat for more
    * ``skip_bad``: Leave out rows of the curves that cannot be read, with a warning that names them
    * ``theta``: Elevation angles of the UAV [deg]: A:B:S with both ends, or a list; default 5:90:5
    * ``distance``: Ground distances of the users [m], instead of elevation angles
    * ``radius``: Users over the whole area within this radius of the UAV [m], instead of on a circle
    * ``phi``: Azimuths [deg]: 0 across the user's street, 90 along it; default: the mean over all
    * ``alpha``: Values of α instead of the city's
    * ``beta``: Values of β instead of the city's [1/km²]
    * ``gamma``: Values of γ instead of the city's [m]
    * ``users``: Users that count: outdoor, street, crossroad
    * ``placement``: Place of the UAV; several separated by commas
    * ``uav_clear_of_roof``: Count only UAVs that are clear of the roof below them; otherwise one inside a building is NLoS to all
    * ``rx_height``: Height of the receivers above ground or roof [m]
    * ``until``: Stop when all intervals are ±P or narrower
    * ``tolerance``: Largest error of any P_LoS, such as 0.005, at the least effort
    * ``ci``: Confidence of the intervals
    * ``cities``: Cities that `city` draws
    * ``users_per_city``: Users on the circle, or in the area, of each city that `city` draws; with `phi` 8, one in each octant
    * ``links``: Links that `geometry` draws for each value
    * ``positions``: UAV positions over a real city
    * ``theta_band``: Over a real city P_LoS at an angle is that of users who see the UAV within so many degrees of it
    * ``block``: Edge of the blocks of a real city that are resampled for its intervals [m]; default: an eighth of the city, at least 100 m
    * ``terrain``: Terrain model below the surface model or the footprints
    * ``ground``: Flat ground at this height above the datum [m], or `buildings`
    * ``building_threshold``: A cell whose surface is more than this above the ground is a building [m]
    * ``height_field``: Property of a footprint's height above ground; default `height`
    * ``top_field``: Property that holds the height of a footprint's top above the datum, instead
    * ``height_unit``: Unit of heights of footprints that name none
    * ``base_field``: Property that holds the ground below a footprint [m above the datum], for `top_field` and `ground buildings`; default the first there is of `b3_h_maaiveld`, `ground_height`, `z_ground`, `h_ground`, `ground`
    * ``levels_field``: Property that holds a footprint's number of storeys, for `missing levels`; default the first there is of `building:levels`, `num_floors`, `storeysAboveGround`, `numberOfFloorsAboveGround`
    * ``height_error_field``: Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    * ``roofs``: Roofs of surfaces, as in CityJSON and CityGML, or of a mesh, which is read as buildings then
    * ``layer``: Table of a GeoPackage, where it has several
    * ``missing``: Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
    * ``parts``: Outlines of buildings that are drawn by parts as well
    * ``base``: Terrain cell below a footprint that its height is above
    * ``data_area``: Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
    * ``extent``: Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    * ``cell``: Cell size, of a raster its own [m]; default 1
    * ``crs``: Coordinate reference system of the scene, where its files name none or a wrong one
    * ``project``: Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web Mercator; EPSG:n, or as `crs`. Of a raster each cell takes the height of the cell of the file that holds its center
    * ``swap_axes``: Exchange x and y of all positions of footprints, where the file has them in the other order than `info` says
    * ``size``: Edge length of a generated city [m]
    * ``seed``: Seed of everything random
    * ``nodata_as``: Effect of nodata cells on links
    * ``band``: Band of a raster that holds its heights, by number from 1 or by name
    * ``hash``: Hash inputs above 64 MB too
    * ``overwrite``: Replace files that exist
    * ``csv_text``: Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind a ' (docs/tables.md)
    * ``plot``: Kind of plot
    * ``title``: Title of the picture, or of the page
    * ``attribution``: Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    * ``width``: Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    * ``dpi``: Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    """

    method: str | Sequence[str] | None
    curve: PathLike | Sequence[PathLike] | None
    skip_bad: bool | None
    theta: float | str | Sequence[float | str] | None
    distance: float | str | Sequence[float | str] | None
    radius: float | str | Sequence[float | str] | None
    phi: float | str | Sequence[float | str] | None
    alpha: float | str | Sequence[float | str] | None
    beta: float | str | Sequence[float | str] | None
    gamma: float | str | Sequence[float | str] | None
    users: Literal["outdoor", "street", "crossroad"] | Sequence[Literal["outdoor", "street", "crossroad"]] | str | None
    placement: Literal["anywhere", "street", "crossroad", "rooftop", "street-center", "crossroad-center", "rooftop-center"] | Sequence[Literal["anywhere", "street", "crossroad", "rooftop", "street-center", "crossroad-center", "rooftop-center"]] | str | None
    uav_clear_of_roof: bool | None
    rx_height: float | str | None
    until: float | None
    tolerance: float | None
    ci: float | None
    cities: int | None
    users_per_city: int | None
    links: int | None
    positions: int | None
    theta_band: float | None
    block: float | None
    terrain: PathLike | None
    ground: float | str | Sequence[float | str] | None
    building_threshold: float | None
    height_field: str | None
    top_field: str | None
    height_unit: Literal["m", "ft"] | None
    base_field: str | None
    levels_field: str | None
    height_error_field: str | None
    roofs: Literal["flat", "lod2"] | None
    layer: str | None
    missing: float | str | Sequence[float | str] | None
    parts: Literal["replace", "join"] | None
    base: Literal["lowest", "mean", "highest"] | None
    data_area: float | str | Sequence[float | str] | None
    extent: Sequence[float] | None
    cell: float | None
    crs: object | None
    project: object | None
    swap_axes: bool | None
    size: float | None
    seed: int | None
    nodata_as: Literal["block", "clear"] | None
    band: float | str | Sequence[float | str] | None
    hash: bool | None
    overwrite: bool | None
    csv_text: bool | None
    plot: Literal["auto", "curves", "heat"] | None
    title: str | None
    attribution: str | None
    width: int | None
    dpi: int | None

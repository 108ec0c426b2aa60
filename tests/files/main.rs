//! What files promise, read and written, good and bad. See tests/README.md.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod formats_read; // rasters in
mod mosaic; // rasters made of many: folders and virtual rasters, as a brush and as GDAL makes one of them
mod mosaic_refusals; // virtual rasters that compute, contradict their tiles, or attack; tiles that do not belong together
mod systems; // reference systems: names, PROJ, web Mercator, 180 degrees
mod bands; // bands of rasters, and what sidecars say of them
mod reprojected; // rasters in degrees: cell by cell by hand and against gdalwarp
mod vertical; // what heights are above, and in which unit
mod in_range; // rasters with a radius: the part in range, the same of all
#[cfg(unix)]
mod streamed; // rasters that do not fit in memory: the maps of memory, what is refused, 50 000 cells a side
#[cfg(unix)]
mod memory_limits; // no run takes more than `--max-memory`

mod formats_write; // rasters out, and back in
mod cog; // GeoTIFFs are cloud optimized
mod polygon_files; // coverage polygons, simplified and not
mod qgis; // rasters as QGIS opens them
mod planning_tools; // what planning tools and simulators take: .bil, KMZ, Mitsuba, ns-3

mod vectors; // one city in every vector format is one scene; policies of heights; refusals
mod held_bytes; // readers given bytes with their sidecars: the city of the file
mod building_meaning; // missing heights, parts, what is not there: by hand, and against a reference in Python
mod building_counts; // how they are counted and told: one number for each warning, shares, captions, names that formats cut
mod city_files;
mod xyz_files; // XYZ grids: the maps of the same raster as an ASCII grid, and what is no grid
mod solid_files; // surfaces of buildings in formats that are not made for them: the maps of CityJSON
mod solid_writers; // writes them
mod osm_files; // data of OpenStreetMap in its encodings, against its areas and GDAL; cut, lying and hostile files
mod point_clouds; // LAS, LAZ and COPC: the city of its rasters, cells by hand, units, extents
mod cityjson_parts; // the same of CityJSON: buildings and their parts, measured heights, fillers
mod ground_truth; // what a scene is made of: bases, voids, typed ground, holes, lattices, extents, ranges
mod repairs; // what was mended or left out, thing by thing

mod inputs; // any file given to `info`: UAVs, tracks, own outputs, strangers
mod bad_inputs; // every bad file gets its documented answer
mod wild; // bad input as it is seen in the wild, row by row
mod small_files; // small files that would take much time or memory
mod tangles; // footprints that cross themselves or lie on one another
mod hostile_cities;
mod hostile_clouds; // headers, chunks and octrees that lie; damaged point clouds
mod hostile_vectors; // damaged vector files are scenes or errors
mod fuzz; // damaged files of every kind, and footprints at random
mod cut_units; // files of units that were cut short, of every format
mod regressions; // one test per bug

#[cfg(unix)]
mod peaks; // what one run takes of memory, measured in a process of its own

// Shared with other binaries.
#[path = "../shared/city_formats.rs"]
mod city_formats;
#[path = "../shared/documents.rs"]
mod documents; // holds documents against their schemas
#[path = "../shared/masks.rs"]
mod masks; // a small town, and masks read back from files
#[path = "../shared/needs.rs"]
mod needs; // parts that are not on every machine: programs, packages, data
#[path = "../shared/osm_files.rs"]
mod osm_files_written; // writes small cities of OpenStreetMap
#[path = "../shared/plain_tiff.rs"]
mod plain_tiff; // writes simple GeoTIFFs
#[path = "../shared/program.rs"]
mod program; // runs the program from outside
#[path = "../shared/recorder.rs"]
mod recorder; // digests of all masks, for two builds side by side
#[path = "../shared/refusals.rs"]
mod refusals; // lines that are refused, flags that are shown at work
#[path = "../shared/rings.rs"]
mod rings; // rings of polygons in GeoJSON
#[path = "../shared/support.rs"]
mod support; // random numbers and scenes
#[path = "../shared/vector_files.rs"]
mod vector_files; // writes one small city in every vector format

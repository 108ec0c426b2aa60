//! What skyshed promises, proved: one binary, its modules in the order of the argument. See tests/README.md.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]
#![expect(clippy::too_many_lines, reason = "tables of cases are long")]

mod oracle; // line of sight in exact rational arithmetic, sharing no geometry code with the crate
mod oracle_proof; // the oracle proves itself on cases computed by hand
mod oracle_proof_prisms; // the same for prisms
mod oracle_twins; // and against brute-force twins on random scenes
mod case_file; // reads tests/cases/*.txt

mod agreement; // every engine against the text cases and the oracle
mod sweep; // the bracketed sweep equals ray on small rasters with every kind of tie
mod engines;
mod errors_on_roofs; // whole maps by the engine for the scene are those of a ray per receiver
mod invariants; // properties of the oracle and of the engines: swap, mirror, quarter turn, split, raise
mod together; // layers of all UAVs: union, count, which, best server
mod approximate; // step, xdraw and r2 against restatements of their rules; the sign and size of their errors
mod shadow; // the engine `shadow` against `ray`, cell for cell
mod plateaus; // shadows of a raster's plateaus against `ray`, and when they are taken
mod sloped_roofs; // roofs that are planes: ray and shadow against the oracle, houses drawn by hand and at random
mod lod2; // roofs as files hold them: a real city against a tracer of its surfaces, errors that move whole roofs, flags
mod shadow_positions; // the same from the ground: receivers and the UAVs that they see
mod adversarial; // grazing, corners, walls, ties, neighboring lattice points, extremes
mod truth; // real cities against an independent engine's masks

mod cities; // generated cities: golden hashes, statistics
mod tiles; // α, β, γ by tile: by hand, of generated cities, read back by GDAL
mod zones; // street, crossroad, courtyard, rooftop: drawn cases, and the triangulation against the construction
mod zones_turned; // the same zones from all sides: mirrored, turned, shifted, in another order
mod models; // every published P_LoS model against its table of values
mod los_probability; // P_LoS of generated cities: reference values, brute force, both simulators, intervals
mod simulators; // both simulators against the product, each other and rays
mod intervals; // 95 % intervals cover 95 % of the time
mod formats_read; // rasters in
mod mosaic; // rasters made of many: folders and virtual rasters, as a brush and as GDAL makes one of them
mod mosaic_refusals; // virtual rasters that compute, contradict their tiles, or attack; tiles that do not belong together
mod systems; // reference systems: names, PROJ, web Mercator, 180 degrees
mod bands; // bands of rasters, and what sidecars say of them
mod reprojected; // rasters in degrees: cell by cell by hand and against gdalwarp
mod formats_write; // rasters out, and back in
mod cog; // GeoTIFFs are cloud optimized
mod qgis; // rasters as QGIS opens them
mod planning_tools; // what planning tools and simulators take: .bil, KMZ, Mitsuba, ns-3
mod polygon_files; // coverage polygons, simplified and not
mod bad_inputs; // every bad file gets its documented answer
mod docs; // every command of the manual runs
mod inputs; // any file given to `info`: UAVs, tracks, own outputs, strangers
mod vertical; // what heights are above, and in which unit
mod small_files; // small files that would take much time or memory
#[cfg(unix)]
mod signals; // interrupted at any moment a run is gone at once, and what it wrote is whole
#[cfg(unix)]
mod memory_limits; // no run takes more than `--max-memory`
mod tangles; // footprints that cross themselves or lie on one another
mod wild; // bad input as it is seen in the wild, row by row
mod fuzz; // damaged files of every kind, and footprints at random
mod vectors; // one city in every vector format is one scene; policies of heights; refusals
mod repairs; // what was mended or left out, thing by thing
mod held_bytes; // readers given bytes with their sidecars: the city of the file
mod hostile_vectors; // damaged vector files are scenes or errors
mod front_door; // the library answers what the program does
mod cli; // the program from outside: words, exit codes, flags
mod cli_help; // what help says: its length, its examples, its defaults
mod answers; // what every command says: its answer, its files, errors in one form
#[cfg(target_os = "linux")]
mod hints; // the command that a hint names is typed, and works; sources and tests name the same hints
mod tables; // UAVs, tracks and curves: bad rows, feet, decimal commas, standard input, names that mean something
#[cfg(unix)]
mod odd_paths; // names of files that are no Unicode
mod over_nodata; // a UAV over no data: a map, and no P_LoS
mod idle_flags; // no flag of any command is taken in silence
mod cli_flags; // where flags of the scene, the UAVs and the receivers change a map
mod cli_link; // one link, a city, facts of a scene
mod cli_map; // maps as files and documents
mod figures; // what pictures show and say, against the numbers of files; their width and resolution
mod captions; // what captions say of refined curves, bands of angles and the limits of a picture
mod cli_zones; // zones of a scene as files and words, P_LoS of a map by zone
mod cli_plos; // P_LoS studies as tables, documents and plots
mod sampled; // P_LoS by zone of the placement, from maps, against the product
mod compare; // placements side by side: counts by hand, saved masks, intervals, sheets, refusals
mod compare_page; // their page: pictures, words of users, a browser
mod live; // the live page: digests, sizes, hostile words, a browser
mod live_claims; // what pages say: fields, commands, links, marks, shares, places over no data
mod live_fields; // fields and addresses of the live page: what is typed means what it means to the program
mod economy; // footprints that hide nobody, what a map needs and what limits it, against maps of the changed scenes
mod tolerance; // the coarsest cells within a tolerance: its bound holds, on generated and on real cities
mod track; // line of sight along a track: stretches, links, files
mod height_errors; // what is sure of maps whose heights are known to within an error: no heights within them leave it
mod redrawn_heights; // scenes drawn from errors of heights are those built anew; intervals cover what they say
mod height_error_flags; // what the program says of heights that may be off
mod height_curve; // P_LoS against the UAV's height, exact at every height
mod height_layers; // margins and ceilings by an engine are those of rays, to the last bit, over real cities
mod chart; // speed against accuracy: counts by hand and from saved maps, sums, threads
mod cli_chart; // its command: the picture from its table, interrupts, peers, flags
mod placement; // where to hover: against brute force, optima and linear searches
mod cli_place; // its command
mod told; // names and degrees of sites, counts, infinite heights, weights: alike and true in every file
mod in_range; // rasters with a radius: the part in range, the same of all
#[cfg(unix)]
mod streamed; // rasters that do not fit in memory: the maps of memory, what is refused, 50 000 cells a side
mod map_sites; // a run for each UAV: the files of single runs, what is left alone, killed at any moment
mod map_tiles; // tiles of the ground, cell for cell those of the whole, and what jobs tell of units
mod cut_units; // files of units that were cut short, of every format
mod stress; // families of scenes where methods fail: the truth against the oracle, engines against the truth
mod curvature; // the curve of the earth against the oracle in exact arithmetic
mod curved_footprints; // and over footprints, whose roofs are curved like the earth
mod antennas; // who is in range of a sector, a beam, between elevations: by the definition in whole numbers
mod in_air; // places of a drone: who they are, and whom an observer sees
mod stability; // which answers turn with the last digit: by hand, by maps made anew, in files
mod ground_truth; // what a scene is made of: bases, voids, typed ground, holes, lattices, extents, ranges
mod building_meaning; // missing heights, parts, what is not there: by hand, and against a reference in Python
mod building_counts; // how they are counted and told: one number for each warning, shares, captions, names that formats cut
mod cityjson_parts; // the same of CityJSON: buildings and their parts, measured heights, fillers
mod closing; // the data area of footprints: against all discs, whatever the cells are
mod data_area; // where the data end: known ground, missing heights; whole discs, bands of angles, goals within a radius
mod regressions; // one test per bug

mod program; // runs the program from outside
#[cfg(target_os = "linux")]
mod hint_inputs; // the files that the lines of hints read
mod plain_tiff; // writes simple GeoTIFFs
mod polygons; // triangulation and repair of footprints
mod codes; // the page of codes, from the sources
mod keywords; // keywords of the Python package, from the requests
mod schemas; // documents against their JSON Schemas, columns and their meanings
mod recorder; // digests of all masks, for two builds side by side
mod referee; // links and whole maps by an engine, by the oracle and by ray
mod shapes; // small scenes with many ties
mod pictures; // one picture of each kind, pixel by pixel
mod prose; // how documents and doc comments read: lengths and openings
mod needs; // parts that are not on every machine: programs, packages, data
mod support; // random numbers and scenes for the suites above
mod vector_files; // writes one small city in every vector format

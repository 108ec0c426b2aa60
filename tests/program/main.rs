//! What the program and its pages promise, proved from outside. See tests/README.md.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]
#![expect(clippy::too_many_lines, reason = "tables of cases are long")]

mod cli; // the program from outside: words, exit codes, flags
mod cli_help; // what help says: its length, its examples, its defaults
mod cli_flags; // where flags of the scene, the UAVs and the receivers change a map
mod idle_flags; // no flag of any command is taken in silence
mod answers; // what every command says: its answer, its files, errors in one form
#[cfg(target_os = "linux")]
mod hints; // the command that a hint names is typed, and works; sources and tests name the same hints
mod tables; // UAVs, tracks and curves: bad rows, feet, decimal commas, standard input, names that mean something
#[cfg(unix)]
mod odd_paths; // names of files that are no Unicode
#[cfg(unix)]
mod signals; // interrupted at any moment a run is gone at once, and what it wrote is whole
mod front_door; // the library answers what the program does

mod cli_link; // one link, a city, facts of a scene
mod cli_map; // maps as files and documents
mod cli_zones; // zones of a scene as files and words, P_LoS of a map by zone
mod cli_plos; // P_LoS studies as tables, documents and plots
mod cli_place; // where to hover: answers, files and refusals of `place`
mod flights; // flights and lists: files of paths, missions, observers, links, bad UAVs
mod stretches; // stretches of flights: single links at their places, a raster and its footprints
mod over_time; // UAVs that come and go: shares of time, gaps, counts between moments
mod track; // line of sight along a track: stretches, links, files
mod height_error_flags; // what the program says of heights that may be off
mod told; // names and degrees of sites, counts, infinite heights, weights: alike and true in every file
mod over_nodata; // a UAV over no data: a map, and no P_LoS
mod data_area; // where the data end: known ground, missing heights; whole discs, bands of angles, goals within a radius

mod map_sites; // a run for each UAV: the files of single runs, what is left alone, killed at any moment
mod map_tiles; // tiles of the ground, cell for cell those of the whole, and what jobs tell of units

mod compare; // placements side by side: counts by hand, saved masks, intervals, sheets, refusals
mod compare_page; // their page: pictures, words of users, a browser
mod chart; // speed against accuracy: counts by hand and from saved maps, sums, threads
mod cli_chart; // its command: the picture from its table, interrupts, peers, flags

mod figures; // what pictures show and say, against the numbers of files; their width and resolution
mod captions; // what captions say of refined curves, bands of angles and the limits of a picture
mod pictures; // one picture of each kind, pixel by pixel

mod live; // the live page: digests, sizes, hostile words, a browser
mod live_claims; // what pages say: fields, commands, links, marks, shares, places over no data
mod live_tracks; // tracks on the live page: stretches, side view, refusals
mod live_fields; // fields and addresses of the live page: what is typed means what it means to the program

mod docs; // every command of the manual runs
mod codes; // the page of codes, from the sources
mod keywords; // keywords of the Python package, from the requests
mod schemas; // the schemas and columns in docs/, from the types
mod prose; // how documents and doc comments read: lengths and openings

#[cfg(target_os = "linux")]
mod hint_inputs; // the files that the lines of hints read

// Shared with other binaries.
#[path = "../shared/documents.rs"]
mod documents; // holds documents against their schemas
#[path = "../shared/masks.rs"]
mod masks; // a small town, and masks read back from files
#[path = "../shared/needs.rs"]
mod needs; // parts that are not on every machine: programs, packages, data
#[path = "../shared/plain_tiff.rs"]
mod plain_tiff; // writes simple GeoTIFFs
#[path = "../shared/products.rs"]
mod products; // P_LoS by the product, to compare with
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
#[path = "../shared/texts.rs"]
mod texts; // small scenes as texts, tables read back
#[path = "../shared/vector_files.rs"]
mod vector_files; // writes one small city in every vector format

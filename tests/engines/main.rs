//! What the engines and the statistics promise, proved mostly through the library, in the order of the argument. See tests/README.md.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod oracle; // line of sight in exact rational arithmetic, sharing no geometry code with the crate
mod oracle_proof; // the oracle proves itself on cases computed by hand
mod oracle_proof_prisms; // the same for prisms
mod oracle_twins; // and against brute-force twins on random scenes
mod case_file; // reads tests/cases/*.txt

mod agreement; // every engine against the text cases and the oracle
mod sweep; // the bracketed sweep equals ray on small rasters with every kind of tie
mod engines; // whole maps by the engine for the scene are those of a ray per receiver
mod invariants; // properties of the oracle and of the engines: swap, mirror, quarter turn, split, raise
mod together; // layers of all UAVs: union, count, which, best server
mod approximate; // step, xdraw and r2 against restatements of their rules; the sign and size of their errors
mod shadow; // the engine `shadow` against `ray`, cell for cell
mod shadow_positions; // the same from the ground: receivers and the UAVs that they see
mod plateaus; // shadows of a raster's plateaus against `ray`, and when they are taken
mod sloped_roofs; // roofs that are planes: ray and shadow against the oracle, houses drawn by hand and at random
mod lod2; // roofs as files hold them: a real city against a tracer of its surfaces, errors that move whole roofs, flags
mod adversarial; // grazing, corners, walls, ties, neighboring lattice points, extremes
mod truth; // real cities against an independent engine's masks
mod stress; // families of scenes where methods fail: the truth against the oracle, engines against the truth

mod curvature; // the curve of the earth against the oracle in exact arithmetic
mod curved_footprints; // and over footprints, whose roofs are curved like the earth
mod antennas; // who is in range of a sector, a beam, between elevations: by the definition in whole numbers
mod in_air; // places of a drone: who they are, and whom an observer sees

mod height_errors; // what is sure of maps whose heights are known to within an error: no heights within them leave it
mod errors_on_roofs; // receivers on roofs whose heights may be off: they rise and fall with their building
mod redrawn_heights; // scenes drawn from errors of heights are those built anew; intervals cover what they say
mod height_curve; // P_LoS against the UAV's height, exact at every height
mod height_layers; // margins and ceilings by an engine are those of rays, to the last bit, over real cities
mod stability; // which answers turn with the last digit: by hand, by maps made anew, in files
mod tolerance; // the coarsest cells within a tolerance: its bound holds, on generated and on real cities
mod economy; // footprints that hide nobody, what a map needs and what limits it, against maps of the changed scenes

mod polygons; // triangulation and repair of footprints
mod closing; // the data area of footprints: against all discs, whatever the cells are
mod cities; // generated cities: golden hashes, statistics
mod tiles; // α, β, γ by tile: by hand, of generated cities, read back by GDAL
mod zones; // street, crossroad, courtyard, rooftop: drawn cases, and the triangulation against the construction
mod zones_turned; // the same zones from all sides: mirrored, turned, shifted, in another order

mod models; // every published P_LoS model against its table of values
mod los_probability; // P_LoS of generated cities: reference values, brute force, both simulators, intervals
mod simulators; // both simulators against the product, each other and rays
mod intervals; // 95 % intervals cover 95 % of the time
mod sampled; // P_LoS by zone of the placement, from maps, against the product
mod placement; // where to hover: against brute force, optima and linear searches

mod referee; // links and whole maps by an engine, by the oracle and by ray
mod shapes; // small scenes with many ties
mod translation; // points and scenes of the oracle as those of the crate, and back

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
#[path = "../shared/support.rs"]
mod support; // random numbers and scenes
#[path = "../shared/texts.rs"]
mod texts; // small scenes as texts, tables read back

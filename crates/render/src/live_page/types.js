// @ts-check
"use strict";
// The shapes of what the program writes into the page, and of what page and worker say to each other. Comments only.
// Lengths are in meters; x and y are in units of the scene's reference system, x east, y north.

/**
 * @typedef {'agl' | 'roof' | 'amsl'} HeightKind above the ground, above the roof below, above the datum
 * @typedef {{kind: HeightKind, m: number}} Height
 * @typedef {{id: string, x: number, y: number, height: Height}} Uav
 * @typedef {'ground' | 'street' | 'crossroad' | 'courtyard' | 'roof' | 'all' | 'air'} Receivers
 * @typedef {{rx_height: number, receivers: Receivers, radius: number | null, min_radius: number | null, sector: [number, number] | null,
 *   elevation: [number, number] | null, beam: number | null, slant_range: number | null, earth_k: number | null, height_error: number | null}} SightSet
 * @typedef {SightSet & {[option: string]: any}} Sight options of the program, by their names; null is not set
 * @typedef {'one' | 'union' | 'count' | 'who'} Layer
 *
 * @typedef {{receivers: number, los: number}} Share
 * @typedef {{street: Share, crossroad: Share, courtyard: Share, rooftop: Share}} ZoneShares
 * @typedef {{ok: true, amsl_m: number, agl_m: number | null, above_m: number | null, over: string, receivers: number, los: number,
 *   p_los: number | null, reason: string | null, sure: [number, number] | null, zones: ZoneShares | null, asked?: Uav}} SeenWell above_m: above
 *   ground or roof; reason: why there is no share though there are receivers; sure: receivers surely in sight, and those that hang on heights
 * @typedef {{ok: false, code: string, words: string, lowest_amsl_m: number | null}} SeenNot
 * @typedef {SeenWell | SeenNot} Seen what a UAV sees, or why it cannot hover there
 * @typedef {{receivers: number, los: number, seen_by: number[], reason: string | null, who?: number[]}} AllSeen
 *   seen_by: cells seen by no UAV, by one …; who: cells of classes 16 to 21 in layer 'who'
 * @typedef {{uavs: Seen[], all: AllSeen, has_out_of_range: boolean, picture: ArrayBuffer | null, ms: number}} MapAnswer
 *
 * @typedef {{ok: true, value: any} | {ok: false, words: string} | (SeenNot & {height: Height})} FieldAnswer what a text in a field means, or
 *   why it cannot be: a height at which the UAV cannot hover is told
 * @typedef {{has_zones: boolean, has_buildings: boolean, has_no_data: boolean, tone: ArrayBuffer, ms: number}} Opened
 * @typedef {{inside: boolean, row: number, col: number, ground_m: number | null, roof_m: number | null,
 *   kind: 'open' | 'building' | 'void', zone: string | null, sees: (boolean | null)[], margin_m: number | null}} CellAnswer
 * @typedef {{x: number, y: number, amsl_m: number}} Place
 * @typedef {{kind: 'building' | 'terrain' | 'cell' | 'nodata' | 'horizon', name: string | null, x: number, y: number,
 *   ray_height_m: number, roof_height_m: number | null}} Obstruction
 * @typedef {{from_m: number, to_m: number, heights_m: [number, number], kind: 'terrain' | 'building'}} ProfileStep
 *   distances are from the UAV
 * @typedef {{ok: true, los: boolean, margin_m: number | null, distance_m: number, elevation_deg: number, uav: Place,
 *   receiver: Place, obstruction: Obstruction | null, steps: ProfileStep[]}} LinkSeen
 * @typedef {LinkSeen | {ok: false, words: string}} LinkAnswer
 * @typedef {{name: string | null, vertices: [number, number, number | null, number | null][]}} Track x, y, height above the datum, time [s]
 * @typedef {'los' | 'nlos' | 'inside' | 'nodata'} TrackState
 * @typedef {{state: TrackState, along_m: [number, number], time_s: [number, number] | null, places: [number, number][],
 *   obstacle: {kind: Obstruction['kind'], name: string | null, x: number, y: number} | null}} Stretch
 * @typedef {{stretches: Stretch[], lengths_m: [number, number, number, number], times_s: [number, number, number, number] | null,
 *   longest_without_m: number, longest_without_s: number | null, every_m: number | null}} StretchesAnswer lengths and times by state
 * @typedef {{along_m: number, time_s: number | null, x: number, y: number, user_m: number, ground_m: number | null,
 *   roof_m: number | null}} TrackPlace
 * @typedef {{done?: boolean, stopped?: boolean, share: number, receivers: number, ground_m: number | null,
 *   lowest_m: number, heights_m: number[], los: number[]}} CurveAnswer heights above the datum, ascending
 * @typedef {{x: number, y: number, los: number, receivers: number}} Candidate
 * @typedef {{done?: boolean, stopped?: boolean, share: number, tried: number, best: Candidate | null}} BestAnswer
 * @typedef {{ok: true, receivers: number, los: number, p_los: number | null, reason: string | null, gained: number, lost: number} |
 *   {ok: false, words: string}} ComparedRow
 *
 * @typedef {{x_min: number, y_max: number, cell_width: number, cell_height: number, n_cols: number, n_rows: number,
 *   meters_per_unit: number}} Grid
 * @typedef {{label: string, name: string, epsg: number | null, wkt: string | null, geographic: boolean}} Crs
 * @typedef {{name: string, word: string, title: string, program: string, command: string[], grid: Grid, crs: Crs | null,
 *   limits: string[], is_part: boolean, surface_only: boolean, most_uavs: number, attribution: string | null, defaults: {[option: string]: any}, start: {uavs: Uav[], sight: Sight, layer: Layer},
 *   tracks: Track[], track_every_m: number}} Facts
 *
 * @typedef {{name: string, uavs: Uav[], sight: Sight}} Kept a placement that is kept
 * @typedef {{x: number, y: number, scale: number}} View the place in the middle, and CSS pixels per unit
 * @typedef {'en' | 'de'} Language
 * @typedef {'light' | 'dark'} Theme
 * @typedef {[number, number, number]} Rgb
 */

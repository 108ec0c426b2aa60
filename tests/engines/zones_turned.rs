//! Zones of a scene that is mirrored, turned, shifted or listed in another order: those of the scene, cell by cell.
//!
//! Corners on one circle have several Delaunay triangulations, so rectangles, round squares and grids of cells are drawn
//! here again and again. A cell whose center lies on a wall is on the building or beside it, and is not compared.

use std::path::Path;

use skyshed_core::city::{City, DataArea, Footprint, FootprintFaults, Ground, Solids};
use skyshed_core::height_field::HeightField;
use skyshed_core::overlay::even_odd;
use skyshed_core::quantity::Frame;
use skyshed_core::raster::{BitGrid, GeoRef};
use skyshed_core::zones::ZoneMap;
use skyshed_io::read::{FootprintOptions, read_footprints};

use crate::cities::generated;
use crate::support::{Random, is_long, surface_field};

const STEPS: i64 = 1024;

/// A symmetry of the square.
#[derive(Debug, Clone, Copy)]
struct Image {
    is_mirrored_in_x: bool,
    is_mirrored_in_y: bool,
    /// Swaps x and y, after the mirrors.
    is_transposed: bool,
}

impl Image {
    /// Returns all but the identity: both mirrors, the half turn, both quarter turns and both diagonals.
    fn all() -> impl Iterator<Item = Image> {
        (1..8).map(|bits| Image {
            is_mirrored_in_x: bits & 1 != 0,
            is_mirrored_in_y: bits & 2 != 0,
            is_transposed: bits & 4 != 0,
        })
    }

    /// Returns where a point of a box of this width and height goes. The box's south-west corner is the origin.
    fn point(self, [x, y]: [i64; 2], [width, height]: [i64; 2]) -> [i64; 2] {
        let x = if self.is_mirrored_in_x { width - x } else { x };
        let y = if self.is_mirrored_in_y { height - y } else { y };
        if self.is_transposed { [y, x] } else { [x, y] }
    }

    /// Returns where a cell of a grid of this many rows and columns goes.
    fn cell(self, [row, col]: [usize; 2], [n_rows, n_cols]: [usize; 2]) -> [usize; 2] {
        let col = if self.is_mirrored_in_x { n_cols - 1 - col } else { col };
        let row = if self.is_mirrored_in_y { n_rows - 1 - row } else { row };
        // Rows are counted from the north: x and y swap about the other diagonal of the array.
        if self.is_transposed { [n_cols - 1 - col, n_rows - 1 - row] } else { [row, col] }
    }

    /// Returns a scene of footprints turned in its place. Its cells are square, and its corners on the lattice.
    fn of(self, scene: &City) -> City {
        let mut city = scene.clone();
        let grid = &scene.grid;
        let Solids::Vector { footprints, frame, .. } = &mut city.solids else { panic!("footprints") };
        let (west, south) = frame.lattice_from_world(grid.x_min(), grid.y_min());
        let (east, north) = frame.lattice_from_world(grid.x_max(), grid.y_max());
        for p in footprints.iter_mut().flat_map(|f| &mut f.polygons).flatten().flatten() {
            let [x, y] = self.point([i64::from(p[0]) - west, i64::from(p[1]) - south], [east - west, north - south]);
            *p = [x + west, y + south].map(|v| i32::try_from(v).unwrap());
        }
        if self.is_transposed {
            let cell = grid.cell_width();
            let corner = (grid.x_min(), grid.y_min() + cell * grid.n_cols() as f64);
            city.grid = GeoRef::new(corner, (cell, cell), (grid.n_cols(), grid.n_rows()), None).unwrap();
        }
        city
    }
}

fn build(scene: &City) -> HeightField {
    HeightField::build(&scene.grid, scene.solids.clone()).field
}

/// Returns the cells whose centers lie on a wall.
fn on_walls(scene: &City) -> BitGrid {
    let mut cells = BitGrid::new(scene.grid.n_rows(), scene.grid.n_cols());
    let Solids::Vector { footprints, frame, .. } = &scene.solids else { panic!("footprints") };
    let grid = &scene.grid;
    let xs: Vec<i64> = (0..grid.n_cols())
        .map(|col| grid.world_from_cell(0, col).0)
        .map(|x| frame.lattice_from_world(x, 0.0).0)
        .collect();
    let ys: Vec<i64> = (0..grid.n_rows())
        .map(|row| grid.world_from_cell(row, 0).1)
        .map(|y| frame.lattice_from_world(0.0, y).1)
        .collect();
    for ring in footprints.iter().flat_map(|f| &f.polygons).flatten() {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let [[ax, ay], [bx, by]] = [a, b].map(|p| p.map(i64::from));
            let between = |v: i64, a: i64, b: i64| (a.min(b)..=a.max(b)).contains(&v);
            for (row, y) in ys.iter().enumerate().filter(|(_, y)| between(**y, ay, by)) {
                let first = xs.partition_point(|x| *x < ax.min(bx));
                for (col, x) in xs.iter().enumerate().skip(first).take_while(|(_, x)| **x <= ax.max(bx)) {
                    if (bx - ax) * (y - ay) == (by - ay) * (x - ax) {
                        cells.insert(row, col);
                    }
                }
            }
        }
    }
    cells
}

/// Returns the number of cells whose zone is another in an image of a scene.
fn n_different(field: &HeightField, aside: &BitGrid, image: Image, of_image: &HeightField) -> usize {
    let (map, other) = (ZoneMap::of_open_ground(field).unwrap(), ZoneMap::of_open_ground(of_image).unwrap());
    let size = [map.grid().n_rows(), map.grid().n_cols()];
    let cells = (0..size[0]).flat_map(|row| (0..size[1]).map(move |col| [row, col]));
    let differs = |cell: &[usize; 2]| {
        let [row, col] = image.cell(*cell, size);
        map.of_cell(cell[0], cell[1]) != other.of_cell(row, col)
    };
    cells.filter(|[row, col]| !aside.contains(*row, *col)).filter(differs).count()
}

/// Checks a scene of footprints in all its images.
fn check(scene: &City, what: &str) {
    let field = build(scene);
    let aside = on_walls(scene);
    for image in Image::all() {
        let n = n_different(&field, &aside, image, &build(&image.of(scene)));
        assert_eq!(n, 0, "{what}: {image:?}");
    }
}

fn munich(cell_m: f64, extent: Option<[f64; 4]>) -> City {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let options = FootprintOptions { cell_m: Some(cell_m), extent, ..FootprintOptions::default() };
    read_footprints(&path, &options, &mut Vec::new()).unwrap()
}

/// Rectangles had either diagonal: a mirrored Munich had 91 other cells of 2 m, and in a cut-out a crossroad became street.
#[test]
fn munich_and_cutouts_of_it_have_the_same_zones_from_all_sides() {
    let city = munich(if is_long() { 1.0 } else { 4.0 }, None);
    let grid = &city.grid;
    check(&city, "all of it");
    let mut random = Random(5);
    for _ in 0..if is_long() { 50 } else { 8 } {
        let cell = random.choose(&[1.0, 2.0]);
        let most = if is_long() { 400 } else { 250 };
        let [width, height] = [(); 2].map(|()| 2 * random.within(50, most / 2));
        let mut from = |low: f64, high: f64, size: i64| {
            #[expect(clippy::cast_possible_truncation, reason = "meters")]
            let place = random.within(low as i64, high as i64 - size);
            [place as f64, (place + size) as f64]
        };
        let [west, east] = from(grid.x_min(), grid.x_max(), width);
        let [south, north] = from(grid.y_min(), grid.y_max(), height);
        let extent = [west, south, east, north];
        check(&munich(cell, Some(extent)), &format!("{extent:?} in cells of {cell} m"));
    }
}

/// A scene of footprints in lattice steps on a grid of 1 m cells from the origin.
fn city(rings: Vec<Vec<[i64; 2]>>, [width, height]: [usize; 2]) -> City {
    let footprints = rings.into_iter().enumerate().map(|(k, ring)| {
        let ring = ring.into_iter().map(|p| p.map(|v| i32::try_from(v).unwrap())).collect();
        Footprint::on_zero(k.to_string(), even_odd(&[ring]), 10 * 1024)
    });
    City {
        name: String::new(),
        grid: GeoRef::new((0.0, height as f64), (1.0, 1.0), (height, width), None).unwrap(),
        solids: Solids::Vector {
            footprints: footprints.collect(),
            frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
            ground: Ground::Flat(0),
            faults: FootprintFaults::default(),
            data_area: DataArea::All,
        },
        built_up: None,
        sources: Vec::new(),
        attribution: None,
        heights: None,
    }
}

/// Rectangles along the axes that touch, overlap, and leave streets of equal widths.
fn blocks(random: &mut Random, size: [usize; 2]) -> Vec<Vec<[i64; 2]>> {
    let unit = random.choose(&[512, 1024, 2048, 5 * 1024]);
    let most = size.map(|size| i64::try_from(size).unwrap() * STEPS / unit);
    (0..random.within(2, 24))
        .map(|_| {
            let [west, south] = [0, 1].map(|k| random.within(-2, most[k]) * unit);
            let [width, height] = [(); 2].map(|()| random.within(1, 16 * 1024 / unit) * unit);
            vec![[west, south], [west + width, south], [west + width, south + height], [west, south + height]]
        })
        .collect()
}

/// A grid of equal blocks, some of which are missing.
fn street_grid(random: &mut Random, size: [usize; 2]) -> Vec<Vec<[i64; 2]>> {
    let unit = random.choose(&[512, 1024]);
    let [block, street, offset] = [(4, 12), (2, 8), (-6, 6)].map(|(low, high)| random.within(low, high) * unit);
    let period = block + street;
    let n = size.map(|size| i64::try_from(size).unwrap() * STEPS / period);
    let mut rings = Vec::new();
    for (i, j) in (-1..=n[0]).flat_map(|i| (-1..=n[1]).map(move |j| (i, j))) {
        if !random.chance(15) {
            let [x, y] = [i * period + offset, j * period + street / 2];
            rings.push(vec![[x, y], [x + block, y], [x + block, y + block], [x, y + block]]);
        }
    }
    rings
}

/// True rectangles in any direction. Where they overlap, walls cross off the lattice.
fn turned_blocks(random: &mut Random, size: [usize; 2]) -> Vec<Vec<[i64; 2]>> {
    let directions = [[3, 4], [1, 1], [5, -12], [7, 2], [1, 0], [20, 1]];
    let one = random.choose(&directions);
    (0..random.within(2, 20))
        .map(|_| {
            let [u, v] = if random.chance(60) { one } else { random.choose(&directions) };
            let longest = i64::isqrt(u * u + v * v);
            let at = size.map(|size| random.within(0, i64::try_from(size).unwrap() * STEPS));
            let [long, wide] = [(); 2].map(|()| random.within(1, 14 * 1024 / longest));
            let corner = |a: i64, b: i64| [at[0] + a * u - b * v, at[1] + a * v + b * u];
            vec![corner(0, 0), corner(long, 0), corner(long, wide), corner(0, wide)]
        })
        .collect()
}

/// Points on the circle of radius 65 in counterclockwise order.
fn circle() -> Vec<[i64; 2]> {
    let quarter = [[65, 0], [63, 16], [60, 25], [56, 33], [52, 39], [39, 52], [33, 56], [25, 60], [16, 63]];
    let turned = |k: usize| quarter.into_iter().map(move |[x, y]| [[x, y], [-y, x], [-x, -y], [y, -x]][k]);
    (0..4).flat_map(turned).collect()
}

/// Round squares: wedges around a center, some of which are missing, so that all their corners lie on two circles.
fn round_squares(random: &mut Random, size: [usize; 2]) -> Vec<Vec<[i64; 2]>> {
    let mut rings = Vec::new();
    for _ in 0..random.within(1, 3) {
        let at = size.map(|size| random.within(10, i64::try_from(size).unwrap() - 10) * STEPS / 2 * 2);
        let (inner, outer) = (random.within(60, 160), random.within(170, 260));
        let every = random.index(1, 4);
        let points: Vec<[i64; 2]> = circle().into_iter().step_by(every).collect();
        for k in (0..points.len()).filter(|_| !random.chance(25)) {
            let [p, q] = [points[k], points[(k + 1) % points.len()]];
            let place = |p: [i64; 2], r: i64| [at[0] + p[0] * r, at[1] + p[1] * r];
            rings.push(vec![place(p, inner), place(p, outer), place(q, outer), place(q, inner)]);
        }
    }
    rings
}

/// Polygons of any shape, some of which cross themselves.
fn scribbles(random: &mut Random, size: [usize; 2]) -> Vec<Vec<[i64; 2]>> {
    let unit = random.choose(&[1, 37, 512, 1024, 4096]);
    (0..random.within(1, 10))
        .map(|_| {
            let place = |random: &mut Random, k: usize| {
                random.within(-4 * 1024 / unit, i64::try_from(size[k] + 4).unwrap() * STEPS / unit) * unit
            };
            (0..random.within(3, 7)).map(|_| [0, 1].map(|k| place(random, k))).collect()
        })
        .collect()
}

#[test]
fn any_footprints_have_the_same_zones_from_all_sides() {
    let mut random = Random(21);
    type Draw = fn(&mut Random, [usize; 2]) -> Vec<Vec<[i64; 2]>>;
    let kinds: [(&str, Draw); 5] = [
        ("blocks", blocks),
        ("street grid", street_grid),
        ("turned blocks", turned_blocks),
        ("round squares", round_squares),
        ("scribbles", scribbles),
    ];
    for round in 0..if is_long() { 2000 } else { 40 } {
        for (what, draw) in kinds {
            let size = [random.index(30, 70), random.index(30, 70)];
            check(&city(draw(&mut random, size), size), &format!("{what}, round {round}"));
        }
    }
}

#[test]
fn generated_cities_have_the_same_zones_from_all_sides() {
    for (name, seed) in [("suburban", 1), ("urban", 2), ("dense", 3), ("highrise", 4)] {
        let mut city = generated(name, seed, 240.0).city().unwrap();
        city.built_up = None;
        check(&city, name);
    }
}

#[test]
fn any_raster_has_the_same_zones_from_all_sides() {
    let mut random = Random(22);
    for round in 0..if is_long() { 4000 } else { 150 } {
        let [n_rows, n_cols] = [random.index(12, 70), random.index(12, 70)];
        let cell = random.choose(&[0.5, 1.0, 2.5]);
        let mut tops = vec![0; n_rows * n_cols];
        for _ in 0..random.index(1, 25) {
            let [[row, height], [col, width]] = [n_rows, n_cols].map(|n| [random.below(n), random.index(1, 14)]);
            // A rectangle, or a slanted strip of cells.
            let slope = if random.chance(50) { 0 } else { random.index(1, 5) };
            for (r, c) in (row..row + height).flat_map(|r| (col..col + width).map(move |c| (r, c))) {
                let c = c + ((r - row) * 2).checked_div(slope).unwrap_or(0);
                if r < n_rows && c < n_cols {
                    tops[r * n_cols + c] = 10 * 1024;
                }
            }
        }
        for top in &mut tops {
            if random.chance(1) {
                *top = 10 * 1024 - *top;
            }
        }
        let field_of = |tops: Vec<i32>, [n_rows, n_cols]: [usize; 2]| {
            let grid = GeoRef::new((0.0, 0.0), (cell, cell), (n_rows, n_cols), None).unwrap();
            surface_field(&grid, tops, Ground::Flat(0))
        };
        let field = field_of(tops.clone(), [n_rows, n_cols]);
        let aside = BitGrid::new(n_rows, n_cols);
        for image in Image::all() {
            let size = if image.is_transposed { [n_cols, n_rows] } else { [n_rows, n_cols] };
            let mut turned = vec![0; tops.len()];
            for (k, top) in tops.iter().enumerate() {
                let [row, col] = image.cell([k / n_cols, k % n_cols], [n_rows, n_cols]);
                turned[row * size[1] + col] = *top;
            }
            let n = n_different(&field, &aside, image, &field_of(turned, size));
            assert_eq!(n, 0, "round {round}: {image:?}");
        }
    }
}

#[test]
fn a_shifted_city_and_one_listed_in_another_order_have_the_same_zones() {
    let mut random = Random(23);
    let mut scenes = vec![munich(2.0, Some([691_300.0, 5_334_700.0, 691_500.0, 5_334_900.0]))];
    for draw in [blocks, turned_blocks, round_squares, scribbles] {
        scenes.extend((0..5).map(|_| city(draw(&mut random, [50, 40]), [50, 40])));
    }
    for scene in scenes {
        let map = ZoneMap::of_open_ground(&build(&scene)).unwrap();
        let mut other = scene.clone();
        let Solids::Vector { footprints, .. } = &mut other.solids else { panic!("footprints") };
        footprints.reverse();
        for ring in footprints.iter_mut().flat_map(|f| &mut f.polygons).flatten() {
            let n = ring.len();
            ring.rotate_left(random.below(n));
            for p in ring {
                *p = [p[0] + 96 * 1024, p[1] - 160 * 1024];
            }
        }
        let grid = &scene.grid;
        let corner = (grid.x_min() + 96.0, grid.y_max() - 160.0);
        other.grid =
            GeoRef::new(corner, (grid.cell_width(), grid.cell_height()), (grid.n_rows(), grid.n_cols()), None).unwrap();
        assert_eq!(ZoneMap::of_open_ground(&build(&other)).unwrap().codes(), map.codes());
    }
}

//! Footprints of any shape: cut into convex pieces and mapped; shadows give the cells that rays give.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use skyshed_core::coverage::{Control, MapOptions, Receivers, Uav, map_site};
use skyshed_core::height_field::{ConvexPieces, HeightField, convex_pieces};
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::{Frame, Height};
use skyshed_core::raster::GeoRef;
use skyshed_core::overlay::even_odd;
use skyshed_core::city::{DataArea, Footprint, FootprintFaults, Ground, Site, Solids};

/// Few heights, so that many are equal.
const HEIGHTS: [i32; 6] = [0, 1, 3072, 3073, 9728, 20_480];

#[derive(Arbitrary, Debug)]
struct City {
    buildings: Vec<Building>,
    /// Of the UAV, in quarters of a meter.
    place: [u8; 2],
    uav_height: u8,
    rx_height: u8,
}

#[derive(Arbitrary, Debug)]
struct Building {
    rings: Vec<Vec<Corner>>,
    height: u8,
}

/// A corner on a coarse lattice, or some steps off it.
#[derive(Arbitrary, Clone, Copy, Debug)]
struct Corner {
    x: u8,
    y: u8,
    off: u8,
}

impl Corner {
    fn on_the_lattice(self) -> [i32; 2] {
        let steps = [0, 0, 0, 1, -1, 307, 512, 7];
        let coordinate = |v: u8, off: u8| i32::from(v % 25) * 2048 + steps[usize::from(off % 8)];
        [coordinate(self.x, self.off), coordinate(self.y, self.off >> 4)]
    }
}

/// Twice the area of a ring, without its sign.
fn doubled_area(ring: &[[i32; 2]]) -> i64 {
    let next = ring.iter().cycle().skip(1);
    let cross = |(a, b): (&[i32; 2], &[i32; 2])| i64::from(a[0]) * i64::from(b[1]) - i64::from(b[0]) * i64::from(a[1]);
    ring.iter().zip(next).map(cross).sum::<i64>().abs()
}

fn footprint(number: usize, building: &Building) -> Option<Footprint> {
    let corners = |ring: &Vec<Corner>| ring.iter().take(10).map(|c| c.on_the_lattice()).collect::<Vec<_>>();
    let rings: Vec<_> = building.rings.iter().take(3).map(corners).filter(|ring| ring.len() > 2).collect();
    let polygons = even_odd(&rings);
    for polygon in &polygons {
        let ConvexPieces::Exact(pieces) = convex_pieces(polygon) else { panic!("{polygon:?} was not cut") };
        let of_pieces: i64 = pieces.iter().map(|piece| doubled_area(piece)).sum();
        let holes: i64 = polygon[1..].iter().map(|ring| doubled_area(ring)).sum();
        assert_eq!(of_pieces, doubled_area(&polygon[0]) - holes, "{polygon:?}");
    }
    let top = HEIGHTS[usize::from(building.height) % HEIGHTS.len()];
    (!polygons.is_empty()).then(|| Footprint { id: number.to_string(), polygons, top, base: Some(0) })
}

fuzz_target!(|city: City| {
    let buildings = city.buildings.iter().take(12).enumerate();
    let footprints: Vec<Footprint> = buildings.filter_map(|(number, b)| footprint(number, b)).collect();
    let grid = GeoRef::new((-2.0, 52.0), (1.0, 1.0), (54, 54), None).expect("a valid grid");
    // The lattice begins at the corner of the grid.
    let frame = Frame { x_origin: -2.0, y_origin: -2.0, unit_x: 1.0, unit_y: 1.0 };
    let solids =
        Solids::Vector { footprints, frame, ground: Ground::Flat(0), faults: FootprintFaults::default(), data_area: DataArea::All, };
    let field = HeightField::build(&grid, solids).field;
    let [x, y] = city.place.map(|v| f64::from(v) / 4.0 - 4.0);
    let height = Height::AboveDatum(f64::from(city.uav_height) / 4.0);
    let Ok(uav) = Uav::place(&Site::new("1", (x, y), height), &field, None) else { return };
    let rx_height = i32::from(city.rx_height % 32) * 512;
    let map = |method: MethodChoice| {
        let options = MapOptions { rx_height, receivers: Receivers::All, method, ..MapOptions::default() };
        map_site(&field, &uav, &options, &Control::default()).expect("a map").mask
    };
    assert_eq!(map(MethodChoice::Shadow), map(MethodChoice::Ray));
});

//! A city as triangle meshes: the ground, and the buildings without floors.

use crate::city::Footprint;
use crate::error::{Error, Result, WriteFault};
use crate::height_field::{roof_triangles, wall_edges};
use crate::quantity::{Frame, meters};
use crate::raster::GeoRef;

/// Triangle mesh; corners are counterclockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corners: x east and y north of the grid's south-west corner, z above the datum \[m\].
    pub vertices: Vec<[f32; 3]>,
    /// Triangles, as indices of vertices.
    pub faces: Vec<[i32; 3]>,
}

/// City to make meshes of.
#[derive(Debug, Clone, Copy)]
pub struct CityMesh<'a> {
    /// The footprints, on the lattice of `frame`.
    pub footprints: &'a [Footprint],
    /// Lattice of the footprints.
    pub frame: Frame,
    /// The extent of the ground, whose south-west corner is the origin.
    pub grid: &'a GeoRef,
    /// Height of the ground at each cell center \[m above the datum\]; NaN where none is known.
    pub ground_m: &'a [f32],
    /// Length of a unit of the CRS \[m\].
    pub meters_per_unit: f64,
}

/// Builds the ground and the buildings of a city.
///
/// Flat ground is a rectangle. Other ground is a surface through the cell centers, with holes where
/// no height is known. That surface slopes where line of sight of a map meets the columns of the
/// terrain, so near slopes the two may differ. Positions on the lattice are exact in 32 bits up to
/// 16 km from the origin.
///
/// # Errors
/// E502 for more corners than a mesh can count.
pub fn city_mesh(city: &CityMesh<'_>) -> Result<(Mesh, Mesh)> {
    let flat = city
        .ground_m
        .first()
        .filter(|z| !z.is_nan() && city.ground_m.iter().all(|other| other.to_bits() == z.to_bits()));
    let ground = match flat {
        Some(z) => flat_ground(city, *z)?,
        None => sloped_ground(city)?,
    };
    let mut buildings = Mesh::default();
    for footprint in city.footprints {
        add_building(&mut buildings, city, footprint)?;
    }
    Ok((ground, buildings))
}

impl Mesh {
    fn vertex(&mut self, at: [f32; 3]) -> Result<i32> {
        let index = i32::try_from(self.vertices.len());
        self.vertices.push(at);
        index.map_err(|_| Error::write("a mesh", WriteFault::Corners))
    }

    /// Adds a convex polygon as triangles around its first corner.
    fn add_convex(&mut self, corners: &[[f32; 3]]) -> Result<()> {
        let indices = corners.iter().map(|corner| self.vertex(*corner)).collect::<Result<Vec<i32>>>()?;
        self.faces.extend((2..indices.len()).map(|k| [indices[0], indices[k - 1], indices[k]]));
        Ok(())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "meshes hold 32 bits")]
fn narrow(v: f64) -> f32 {
    v as f32
}

fn flat_ground(city: &CityMesh<'_>, z: f32) -> Result<Mesh> {
    let east = narrow((city.grid.x_max() - city.grid.x_min()) * city.meters_per_unit);
    let north = narrow((city.grid.y_max() - city.grid.y_min()) * city.meters_per_unit);
    let mut mesh = Mesh::default();
    mesh.add_convex(&[[0.0, 0.0, z], [east, 0.0, z], [east, north, z], [0.0, north, z]])?;
    Ok(mesh)
}

/// Makes two triangles between each four cell centers; centers at the border are moved out to it.
fn sloped_ground(city: &CityMesh<'_>) -> Result<Mesh> {
    let (n_rows, n_cols) = (city.grid.n_rows(), city.grid.n_cols());
    let along = |k: usize, n: usize, size: f64| match k {
        0 => 0.0,
        k if k + 1 == n => n as f64 * size,
        k => (k as f64 + 0.5) * size,
    };
    let (width, height) =
        (city.grid.cell_width() * city.meters_per_unit, city.grid.cell_height() * city.meters_per_unit);
    let mut mesh = Mesh::default();
    for (cell, z) in city.ground_m.iter().enumerate() {
        let (row, col) = (cell / n_cols, cell % n_cols);
        let z = if z.is_nan() { 0.0 } else { *z };
        mesh.vertex([narrow(along(col, n_cols, width)), narrow(along(n_rows - 1 - row, n_rows, height)), z])?;
    }
    for row in 0..n_rows.saturating_sub(1) {
        for col in 0..n_cols.saturating_sub(1) {
            let north_west = row * n_cols + col;
            let four = [north_west + n_cols, north_west + n_cols + 1, north_west + 1, north_west];
            if four.iter().any(|cell| city.ground_m[*cell].is_nan()) {
                continue;
            }
            let [sw, se, ne, nw] = four.map(|cell| i32::try_from(cell).unwrap_or_default());
            mesh.faces.extend([[sw, se, ne], [sw, ne, nw]]);
        }
    }
    Ok(mesh)
}

/// Adds walls from the building's ground to its roof, and its roof.
fn add_building(mesh: &mut Mesh, city: &CityMesh<'_>, footprint: &Footprint) -> Result<()> {
    let base = footprint.bottom();
    let place = |[x, y, z]: [i32; 3]| {
        let (x, y) = city.frame.world_from_lattice(f64::from(x), f64::from(y));
        let unit = city.meters_per_unit;
        [narrow((x - city.grid.x_min()) * unit), narrow((y - city.grid.y_min()) * unit), narrow(meters(z))]
    };
    for [a, b] in wall_edges(footprint) {
        let foot = |[x, y, _]: [i32; 3]| place([x, y, base]);
        mesh.add_convex(&[foot(a), foot(b), place(b), place(a)])?;
    }
    for corners in roof_triangles(footprint).iter() {
        mesh.add_convex(&corners.map(place))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::Ring;

    const FRAME: Frame = Frame { x_origin: 100.0, y_origin: 200.0, unit_x: 1.0, unit_y: 1.0 };

    fn at(meters: [i32; 2]) -> [i32; 2] {
        meters.map(|v| v * 1024)
    }

    fn is_at(corner: [f32; 3], wanted: [f32; 3]) -> bool {
        corner.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    /// Returns the volume between a mesh with outward faces and the plane z = 0, where walls begin.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |k: i32| mesh.vertices[usize::try_from(k).unwrap()].map(f64::from);
        let of = |face: &[i32; 3]| {
            let [a, b, c] = face.map(corner);
            let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
        };
        mesh.faces.iter().map(of).sum()
    }

    #[test]
    fn faces_look_outward_and_enclose_the_volume_of_the_building() {
        // 10 × 8 m with a yard of 2 × 2 m, 5 m high, whatever way its rings run.
        let shell: Ring = [[10, 10], [20, 10], [20, 18], [10, 18]].map(at).to_vec();
        let yard: Ring = [[14, 12], [16, 12], [16, 14], [14, 14]].map(at).to_vec();
        let turned = |ring: &Ring| ring.iter().rev().copied().collect::<Ring>();
        let grid = GeoRef::new((100.0, 230.0), (1.0, 1.0), (30, 30), None).unwrap();
        for rings in [vec![shell.clone(), yard.clone()], vec![turned(&shell), yard.clone()], vec![shell, turned(&yard)]]
        {
            let footprint = Footprint::on_zero("a".into(), vec![rings], 5 * 1024);
            let city = CityMesh {
                footprints: &[footprint],
                frame: FRAME,
                grid: &grid,
                ground_m: &[0.0; 900],
                meters_per_unit: 1.0,
            };
            let (ground, buildings) = city_mesh(&city).unwrap();
            assert_eq!(ground.faces.len(), 2);
            assert!(is_at(ground.vertices[2], [30.0, 30.0, 0.0]));
            // The missing floor lies in z = 0 and adds nothing to the sum.
            assert!((volume(&buildings) - 5.0 * 76.0).abs() < 1e-6, "{}", volume(&buildings));
        }
    }

    #[test]
    fn ground_with_relief_passes_through_the_cell_centers_and_leaves_out_what_is_unknown() {
        let grid = GeoRef::new((100.0, 230.0), (10.0, 10.0), (3, 3), None).unwrap();
        let mut ground_m: Vec<f32> = (0..9_u8).map(f32::from).collect();
        ground_m[0] = f32::NAN;
        let city = CityMesh { footprints: &[], frame: FRAME, grid: &grid, ground_m: &ground_m, meters_per_unit: 1.0 };
        let (ground, _) = city_mesh(&city).unwrap();
        assert!(is_at(ground.vertices[4], [15.0, 15.0, 4.0]));
        assert!(is_at(ground.vertices[8], [30.0, 0.0, 8.0]));
        assert_eq!(ground.faces.len(), 6);
    }
}

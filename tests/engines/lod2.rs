//! Roofs as they are: files of surfaces become buildings with their roofs, a real city against a tracer of its surfaces, errors that move whole
//! roofs, and what the program says.

#![expect(clippy::unwrap_used, clippy::cast_precision_loss, reason = "small numbers, and a panic is a failed test")]

use serde_json::{Value, json};
use skyshed_core::city::{Footprint, Ground, Site};
use skyshed_core::coverage::{
    Control, HeightBounds, HeightErrors, MapOptions, Mapper, MovedRoofs, Receivers, RedrawnHeights, Uav,
    UncertainHeights,
};
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{PlanCrossings, link_los};
use skyshed_core::quantity::Height;
use skyshed_core::raster::GeoRef;
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_request::{GroundChoice, Roofs};

use crate::invariants::vector_field;
use crate::program::Folder;
use crate::referee::{Count, over_seeds};
use crate::support::Random;

const DELFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/lod2/delft.city.json");

/// A house of 10 × 6 m on the corner of the coordinates, 6 m to the eaves, 9 m to the ridge along x, as CityJSON; a porch of the roof
/// may reach `porch` m beyond its south wall.
fn house(porch: f64, with_semantics: bool) -> Value {
    let mut vertices = vec![
        [0.0, 0.0, 0.0],
        [10.0, 0.0, 0.0],
        [10.0, 6.0, 0.0],
        [0.0, 6.0, 0.0],
        [0.0, 0.0, 6.0],
        [10.0, 0.0, 6.0],
        [10.0, 6.0, 6.0],
        [0.0, 6.0, 6.0],
        [0.0, 3.0, 9.0],
        [10.0, 3.0, 9.0],
    ];
    let mut faces = vec![
        ("GroundSurface", vec![0, 3, 2, 1]),
        ("WallSurface", vec![0, 1, 5, 4]),
        ("WallSurface", vec![2, 3, 7, 6]),
        ("WallSurface", vec![1, 2, 6, 9, 5]),
        ("WallSurface", vec![3, 0, 4, 8, 7]),
        ("RoofSurface", vec![4, 5, 9, 8]),
        ("RoofSurface", vec![8, 9, 6, 7]),
    ];
    if porch > 0.0 {
        vertices.extend([[0.0, -porch, 6.0], [10.0, -porch, 6.0]]);
        faces.push(("RoofSurface", vec![10, 11, 5, 4]));
    }
    let kinds = ["GroundSurface", "WallSurface", "RoofSurface"];
    let mut geometry = json!({
        "type": "Solid", "lod": "2.2", "boundaries": [faces.iter().map(|(_, ring)| [ring]).collect::<Vec<_>>()],
    });
    if with_semantics {
        let number = |kind: &str| kinds.iter().position(|k| *k == kind);
        let values: Vec<_> = faces.iter().map(|(kind, _)| number(kind)).collect();
        geometry["semantics"] = json!({"surfaces": kinds.map(|kind| json!({"type": kind})), "values": [values]});
    }
    json!({
        "type": "CityJSON", "version": "2.0", "vertices": vertices,
        "CityObjects": {"house": {"type": "Building", "geometry": [geometry]}},
    })
}

/// A building of CityJSON as a Wavefront OBJ mesh.
fn mesh_of(house: &Value) -> String {
    let numbers = |v: &Value| v.as_array().unwrap().iter().map(Value::to_string).collect::<Vec<_>>().join(" ");
    let vertices = house["vertices"].as_array().unwrap().iter().map(|v| format!("v {}\n", numbers(v)));
    let faces = house["CityObjects"]["house"]["geometry"][0]["boundaries"][0].as_array().unwrap().iter();
    let corner = |v: &Value| (v.as_u64().unwrap() + 1).to_string();
    let face = |face: &Value| face[0].as_array().unwrap().iter().map(corner).collect::<Vec<_>>().join(" ");
    vertices.chain(faces.map(|f| format!("f {}\n", face(f)))).collect()
}

#[test]
fn a_gable_is_one_scene_in_every_form_and_hides_less_than_its_ridge() {
    let folder = Folder::new();
    folder.write("marked.city.json", &house(0.0, true).to_string());
    folder.write("plain.city.json", &house(0.0, false).to_string());
    folder.write("house.obj", &mesh_of(&house(0.0, true)));
    let map = |scene: &str, more: &str| {
        let line =
            format!("map {scene} --extent=-30,-30,40,36 --uav 5,-25,12 --receivers all --rx-height 0 {more} --json");
        folder.type_in(&line).done().json()
    };
    let marked = map("marked.city.json", "--roofs lod2");
    for scene in ["plain.city.json", "house.obj"] {
        assert_eq!(map(scene, "--roofs lod2")["digest"], marked["digest"], "{scene}");
    }
    let flat = map("marked.city.json", "--roofs flat");
    assert_eq!(map("marked.city.json", "")["digest"], flat["digest"]);
    // By hand: from 12 m, 25 m south of the house, over the ridge at 9 m and 28 m, the ground behind is hidden up to 112 m away; over
    // the eaves at 6 m and 25 m nothing of the slope that looks here is. Flat, the roof would be seen all over.
    let los = |document: &Value| document["sites"][0]["los"].as_u64().unwrap();
    assert!(los(&marked) < los(&flat), "{} {}", los(&marked), los(&flat));
    let link = |place: &str, roofs: &str| {
        let line =
            format!("link marked.city.json --roofs {roofs} --extent=-30,-30,40,36 --uav 5,-25,12 --rx {place} --json");
        folder.type_in(&line).done().json()
    };
    // The slope away from the UAV: at y = 4.5 the roof is at 7.5 m, and the ray over the ridge comes down to 8.84 m there.
    let behind = link("5,4.5,1.3roof", "lod2");
    assert_eq!(behind["los"], false, "{behind}");
    assert_eq!(link("5,4.5,1.4roof", "lod2")["los"], true);
    let margin = behind["margin_m"].as_f64().unwrap();
    assert!((margin - (8.8 - (12.0 - 3.0 * 29.5 / 28.0))).abs() < 1e-3, "{behind}");
    let top = behind["obstruction"]["roof_height_m"].as_f64().unwrap();
    assert!((top - 9.0).abs() < 1e-3, "{behind}");
    assert_eq!(link("5,4.5,0.1roof", "flat")["los"], true);
}

#[test]
fn what_is_taken_otherwise_than_it_is_drawn_is_told() {
    let folder = Folder::new();
    folder.write("porch.city.json", &house(2.0, true).to_string());
    folder.write("a.geojson", r#"{"type":"Polygon","coordinates":[[[0,0],[9,0],[9,9],[0,0]]]}"#);
    let map = "map porch.city.json --extent=-30,-30,40,36 --uav 5,-25,12";
    let asked = folder.type_in(&format!("{map} --roofs lod2")).done();
    assert!(asked.err.contains("warning[W369]") && asked.err.contains("1 building with a roof"), "{asked:?}");
    assert!(!asked.warnings().contains(&"W375"), "{asked:?}");
    // Solid below the porch, where a receiver is inside.
    let under =
        folder.type_in("link porch.city.json --roofs lod2 --extent=-30,-30,40,36 --uav 5,-25,12 --rx 5,-1,1agl --json");
    assert_eq!((under.code(), under.error()), (4, "E201"), "{under:?}");
    let flat = folder.type_in(map).done();
    assert!(flat.warnings().contains(&"W375") && flat.err.contains("--roofs lod2"), "{flat:?}");
    assert!(!folder.type_in(&format!("{map} --roofs flat")).done().warnings().contains(&"W375"));
    folder.type_in(&format!("{map} --roofs lod2 --repairs list.csv")).done();
    assert!(folder.text("list.csv").contains("overhang"), "{}", folder.text("list.csv"));

    // A half that is not marked is roof, and one that is missing is open ground.
    let mut half = house(0.0, true);
    half["CityObjects"]["house"]["geometry"][0]["semantics"]["values"][0][6] = Value::Null;
    folder.write("half.city.json", &half.to_string());
    folder.write("whole.city.json", &house(0.0, true).to_string());
    let digest = |scene: &str| {
        let line = format!("map {scene} --roofs lod2 --extent=-30,-30,40,36 --uav 5,-25,12 --json");
        folder.type_in(&line).done().json()["digest"].clone()
    };
    assert_eq!(digest("half.city.json"), digest("whole.city.json"));
    half["CityObjects"]["house"]["geometry"][0]["semantics"]["values"][0][6] = json!(1);
    half["CityObjects"]["block"] = half["CityObjects"]["house"].clone();
    half["CityObjects"]["block"]["geometry"][0]["boundaries"] = json!([[[[0, 3, 2, 1]], [[0, 1, 5, 4]]]]);
    half["CityObjects"]["block"]["geometry"][0]["semantics"]["values"] = json!([[0, 1]]);
    folder.write("bare.city.json", &half.to_string());
    let bare = folder.type_in("map bare.city.json --roofs lod2 --extent=-30,-30,40,36 --uav 5,-25,12").done();
    assert!(["W377", "W381"].iter().all(|code| bare.warnings().contains(code)), "{bare:?}");
    folder.refuses("city whole.city.json --roofs lod2 -o boxes.csv", "E109", &["boxes.csv"]);

    let refused = "map a.geojson --roofs lod2 --uav 5,-25,12";
    folder.refuses(refused, "E308", &["a.geojson", "surface of a roof"]);
    folder.refuses(&format!("{map} --roofs lod2 --height-field tall"), "E116", &["--height-field", "roofs"]);
    folder.refuses(&format!("{map} --roofs lod2 --earth-k 1.33"), "E118", &["slope", "--roofs flat"]);
    folder.refuses(&format!("{map} --roofs steep"), "E101", &["steep", "lod2"]);
    folder.refuses("map itu:urban --roofs lod2 --uav 5,5,50", "E116", &["--roofs", "generated city"]);
}

#[test]
fn limits_and_the_chart_say_what_flat_roofs_cost() {
    let folder = Folder::new();
    let limits =
        |words: &str| folder.type_in(&format!("limits {DELFT} --uav 84550,447200,40 {words} --json")).done().json();
    let (shaped, flat) = (limits("--roofs lod2"), limits("--roofs flat"));
    assert_eq!(flat["roofs"], Value::Null);
    let roofs = &shaped["roofs"];
    // Both forms map the same receivers of open ground.
    assert_eq!(roofs["p_los"], flat["p_los"]);
    assert!(roofs["shaped"].as_u64().unwrap() > 40 && roofs["turned"].as_u64().unwrap() > 100, "{roofs}");
    let line = shaped["budget"].as_array().unwrap().iter().find(|line| line["part"] == "roof shapes").unwrap();
    let change = roofs["p_los"].as_f64().unwrap() - shaped["p_los"].as_f64().unwrap();
    assert!((line["p_los_change"].as_f64().unwrap() - change).abs() < 1e-12 && change < 0.0, "{line}");
    let chart = format!("chart {DELFT} --roofs lod2 --uav 84550,447200,40 --json");
    let chart = folder.type_in(&chart).done().json();
    let rows = chart["contestants"].as_array().unwrap();
    let row =
        |parameters: &str| rows.iter().find(|row| row["parameters"] == parameters).unwrap_or_else(|| panic!("{chart}"));
    let wrong = |parameters: &str| row(parameters)["wrong_cells"].as_u64().unwrap();
    assert_eq!(wrong("flat roofs"), roofs["turned"].as_u64().unwrap());
    assert!(wrong("roofs 1 m higher") > 0 && wrong("roofs 1 m higher") < wrong("roofs 3 m higher"), "{chart}");
}

/// A surface of the file: its rings in the plane, and the plane z = a + b (x − x0) + c (y − y0) that fits its corners best, and by how much they
/// are below or above it at most.
struct Surface {
    rings: Vec<Vec<[f64; 2]>>,
    origin: [f64; 2],
    plane: [f64; 3],
    bounds: [f64; 4],
    off: f64,
}

/// The roofs of the file as it holds them, in meters and doubles.
fn roof_surfaces(text: &str) -> Vec<Surface> {
    let document: Value = serde_json::from_str(text).unwrap();
    let three = |v: &Value| [0, 1, 2].map(|k| v[k].as_f64().unwrap());
    let (scale, shift) = (three(&document["transform"]["scale"]), three(&document["transform"]["translate"]));
    let vertices: Vec<[f64; 3]> = document["vertices"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| [0, 1, 2].map(|k| three(v)[k] * scale[k] + shift[k]))
        .collect();
    let mut surfaces = Vec::new();
    for object in document["CityObjects"].as_object().unwrap().values() {
        for geometry in object["geometry"].as_array().into_iter().flatten() {
            let kinds = &geometry["semantics"]["surfaces"];
            for (shell, values) in geometry["boundaries"]
                .as_array()
                .unwrap()
                .iter()
                .zip(geometry["semantics"]["values"].as_array().unwrap())
            {
                for (face, value) in shell.as_array().unwrap().iter().zip(values.as_array().unwrap()) {
                    if kinds[usize::try_from(value.as_u64().unwrap()).unwrap()]["type"] == "RoofSurface" {
                        let ring = |ring: &Value| -> Vec<[f64; 3]> {
                            let number = |v: &Value| vertices[usize::try_from(v.as_u64().unwrap()).unwrap()];
                            ring.as_array().unwrap().iter().map(number).collect()
                        };
                        surfaces.extend(surface_of(&face.as_array().unwrap().iter().map(ring).collect::<Vec<_>>()));
                    }
                }
            }
        }
    }
    surfaces
}

/// A surface with its plane by Newell's normal; `None` if it stands upright.
fn surface_of(rings: &[Vec<[f64; 3]>]) -> Option<Surface> {
    let shell = &rings[0];
    let (n, origin) = (shell.len(), shell[0]);
    let mut normal = [0.0; 3];
    for k in 0..n {
        let [a, b] = [shell[k], shell[(k + 1) % n]].map(|p| [0, 1, 2].map(|i| p[i] - origin[i]));
        for (i, of) in normal.iter_mut().enumerate() {
            let (j, l) = ((i + 1) % 3, (i + 2) % 3);
            *of += (a[j] - b[j]) * (a[l] + b[l]);
        }
    }
    let mean = shell.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|i| sum[i] + (p[i] - origin[i]) / n as f64));
    if normal[2].abs() < 1e-3 * normal[0].hypot(normal[1]) {
        return None;
    }
    let (b, c) = (-normal[0] / normal[2], -normal[1] / normal[2]);
    let plane = [origin[2] + mean[2] - b * mean[0] - c * mean[1], b, c];
    let plan: Vec<Vec<[f64; 2]>> = rings.iter().map(|ring| ring.iter().map(|p| [p[0], p[1]]).collect()).collect();
    let bounds = plan.iter().flatten().fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |b, p| {
        [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])]
    });
    let height = |p: &[f64; 3]| plane[0] + plane[1] * (p[0] - origin[0]) + plane[2] * (p[1] - origin[1]);
    let off = shell.iter().map(|p| (p[2] - height(p)).abs()).fold(0.0, f64::max);
    Some(Surface { rings: plan, origin: [origin[0], origin[1]], plane, bounds, off })
}

impl Surface {
    /// How far a segment is above the surface where it is over it, at least \[m\]; infinite if it is nowhere.
    fn clearance(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let [w, s, e, n] = self.bounds;
        let outside = |k: usize, low: f64, high: f64| from[k].max(to[k]) < low || from[k].min(to[k]) > high;
        if outside(0, w, e) || outside(1, s, n) {
            return f64::INFINITY;
        }
        let way = [to[0] - from[0], to[1] - from[1]];
        let side = |p: [f64; 2]| way[0] * (p[1] - from[1]) - way[1] * (p[0] - from[0]);
        let mut crossings: Vec<f64> = Vec::new();
        for ring in &self.rings {
            for k in 0..ring.len() {
                let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
                let (of_a, of_b) = (side(a), side(b));
                if (of_a > 0.0) != (of_b > 0.0) {
                    let t = of_a / (of_a - of_b);
                    let at = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
                    let along = (at[0] - from[0]) * way[0] + (at[1] - from[1]) * way[1];
                    crossings.push(along / (way[0] * way[0] + way[1] * way[1]));
                }
            }
        }
        crossings.sort_by(f64::total_cmp);
        let mut least = f64::INFINITY;
        for pair in crossings.chunks_exact(2) {
            let (a, b) = (pair[0].max(0.0), pair[1].min(1.0));
            if a >= b {
                continue;
            }
            for t in [a, b] {
                let [x, y] = [0, 1].map(|k| from[k] + t * way[k] - self.origin[k]);
                let roof = self.plane[0] + self.plane[1] * x + self.plane[2] * y;
                least = least.min(from[2] + t * (to[2] - from[2]) - roof);
            }
        }
        least
    }
}

/// Old houses of Delft over flat ground at 0 m.
fn delft(roofs: Roofs) -> HeightField {
    let ground = GroundChoice::Flat(0.0);
    let options = FootprintOptions { roofs: Some(roofs), ground: Some(ground), ..FootprintOptions::default() };
    let city = read_footprints(DELFT, &options, &mut Vec::new()).unwrap();
    HeightField::build(&city.grid, city.solids).field
}

#[test]
fn delft_is_seen_as_a_tracer_of_its_surfaces_sees_it() {
    let surfaces = roof_surfaces(&std::fs::read_to_string(DELFT).unwrap());
    let field = delft(Roofs::Lod2);
    let options = MapOptions { receivers: Receivers::Ground, ..MapOptions::default() };
    let mapper = Mapper::new(&field, &options).unwrap();
    // Two surfaces of the file are no planes, but off by up to two meters: what they decide hangs on how they are triangulated.
    assert_eq!(surfaces.iter().filter(|surface| surface.off > 0.05).count(), 2);
    let (mut cells, mut differ, mut blocked, mut uneven) = (0_u64, 0_u64, 0_u64, 0_u64);
    // Above streets and roofs, low and high, and beside the town.
    for (x, y, height) in [
        (84_550.3, 447_200.7, 30.0),
        (84_455.5, 447_445.5, 12.0),
        (84_600.0, 447_400.0, 120.0),
        (84_380.0, 447_000.0, 60.0),
    ] {
        let site = Site::new("1", (x, y), Height::agl(height));
        let uav = Uav::place(&site, &field, None).unwrap();
        let seen = mapper.seen_from(&uav).unwrap().seen();
        let grid = field.grid();
        for (row, col) in seen.receivers.cells() {
            let (cx, cy) = grid.world_from_cell(row, col);
            // Whether the tracer finds a clear link with both ends moved by so much, and how uneven a surface is that may decide that.
            let traced = |[east, north, up]: [f64; 3]| {
                let (from, to) = ([cx + east, cy + north, 1.5 + up], [x + east, y + north, height + up]);
                surfaces.iter().fold((true, 0.0_f64), |(is_clear, off), surface| {
                    let clearance = surface.clearance(from, to);
                    let may_decide = surface.off > 0.05 && clearance < 4.0;
                    (is_clear && clearance >= 0.0, if may_decide { off.max(surface.off) } else { off })
                })
            };
            let is_los = seen.los.contains(row, col);
            cells += 1;
            blocked += u64::from(!is_los);
            let (is_clear, off) = traced([0.0; 3]);
            if is_clear == is_los {
                continue;
            }
            // Corners are rounded to a millimeter, so a ray that passes one that near may go either way.
            let beside = (0..6).map(|k| [0, 1, 2].map(|axis| if axis == k / 2 { [2e-3, -2e-3][k % 2] } else { 0.0 }));
            if beside.into_iter().any(|by| traced(by).0 == is_los) {
                differ += 1;
            } else {
                assert!(off > 0.0, "row {row}, column {col} from ({x}, {y}, {height}): {is_los}");
                uneven += 1;
            }
        }
    }
    assert!(cells > 100_000 && blocked > 10_000, "{blocked} of {cells} blocked");
    assert!(differ * 10_000 <= cells && uneven * 500 <= cells, "{differ} and {uneven} of {cells} differ");
}

/// Some gabled, hipped and flat houses, each with an error of its own.
fn gables(random: &mut Random) -> Vec<Footprint> {
    let n = random.within(2, 4);
    (0..n)
        .map(|k| {
            let [w, s] = [1 + 5 * k, 2 + random.within(0, 6)];
            let (e, north) = (w + random.within(2, 4), s + 2 * random.within(1, 2));
            let (eaves, ridge) = (random.within(2, 5), random.within(2, 8));
            let at = |x: i64, y: i64, z: i64| [x * 1024, y * 1024, z * 1024].map(|v| i32::try_from(v).unwrap());
            let (a, b, c, d) = (at(w, s, eaves), at(e, s, eaves), at(e, north, eaves), at(w, north, eaves));
            let middle = i64::midpoint(s, north);
            let (f, g) = (at(w, middle, ridge), at(e, middle, ridge));
            let roof = vec![[a, b, g], [a, g, f], [f, g, c], [f, c, d]];
            let ring = [a, b, c, d].map(|[x, y, _]| [x, y]).to_vec();
            let top = 1024 * i32::try_from(eaves.max(ridge)).unwrap();
            Footprint { roof, ..Footprint::on_zero(k.to_string(), vec![vec![ring]], top) }
        })
        .collect()
}

/// Those with all of each roof so many steps higher.
fn raised(houses: &[Footprint], by: &[i32]) -> Vec<Footprint> {
    let house = |(house, by): (&Footprint, &i32)| Footprint {
        roof: house.roof.iter().map(|corners| corners.map(|[x, y, z]| [x, y, z + by])).collect(),
        top: house.top + by,
        ..house.clone()
    };
    houses.iter().zip(by).map(house).collect()
}

const N: usize = 20;

#[test]
fn an_error_of_height_moves_a_whole_roof() {
    let count: Count = over_seeds(60, 0x10d2, |seed, random, count| {
        let houses = gables(random);
        let field = vector_field(houses.clone(), Ground::Flat(0), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let height = Height::AboveDatum(f64::from(random.choose(&[9, 12, 20])));
        let uav = Uav::place(&Site::new("1", (x, y), height), &field, None).unwrap();
        // Each building as it is, or one of two errors off.
        let errors: Vec<[i32; 2]> = houses.iter().map(|_| [0, random.choose(&[-1500, -700, 900, 2048])]).collect();
        let n_fields = 1 << houses.len();
        let by = |all: usize| -> Vec<i32> { errors.iter().enumerate().map(|(k, of)| of[all >> k & 1]).collect() };
        let fields: Vec<HeightField> =
            (0..n_fields).map(|all| vector_field(raised(&houses, &by(all)), Ground::Flat(0), N)).collect();
        let share = |building: u32, room: i64| {
            let of = errors[usize::try_from(building).unwrap()];
            of.iter().filter(|by| i64::from(**by) <= room).count() as f64 / 2.0
        };
        let positions = field.positions();
        for (row, col) in field.cells().open.cells() {
            let receiver = Station { place: positions.center(row, col), z: random.choose(&[0, 1536, 5000]) };
            let limits = PlanCrossings::new(&field, &uav.station, &receiver, 0, 4096).limits(0).unwrap();
            let clear = fields.iter().filter(|field| link_los(field, &uav.station, &receiver)).count();
            let wanted = clear as f64 / n_fields as f64;
            assert_eq!(limits.probability(&share).to_bits(), wanted.to_bits(), "seed {seed}: {receiver:?} {limits:?}");
            count.links += u64::from(clear > 0 && clear < fields.len());
        }
        // Without errors the mask; and no redrawn map leaves what is sure.
        let options = MapOptions { receivers: Receivers::All, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &options).unwrap();
        let known = mapper.seen_from(&uav).unwrap().seen();
        let none = UncertainHeights::of(&field, &HeightErrors::same(0.0, 0.0)).unwrap();
        let p_los = mapper.seen_from(&uav).unwrap().p_los(&none, &Control::default()).unwrap();
        for (cell, p) in p_los.iter().enumerate().filter(|(_, p)| !p.is_nan()) {
            let is_los = known.los.contains(cell / N, cell % N);
            assert_eq!(p.to_bits(), f32::from(u8::from(is_los)).to_bits(), "seed {seed}, cell {cell}: {p}");
        }
        let bounds = HeightBounds::of(&field, 1.0).unwrap();
        let sure = mapper.seen_from(&uav).unwrap().sure(&bounds).unwrap();
        let receivers_above = options.rx_height;
        for k in 0..8 {
            let by: Vec<i32> = houses.iter().map(|_| i32::try_from(random.within(-1024, 1024)).unwrap()).collect();
            let moved = MovedRoofs::by_building(&field, |building| by[building as usize]).unwrap();
            let built = vector_field(raised(&houses, &by), Ground::Flat(0), N);
            for (row, col) in field.cells().open.cells() {
                let place = positions.center(row, col);
                let receiver = Station { place, z: receivers_above.into() };
                let is_los = link_los(&moved.field, &uav.station, &receiver);
                assert_eq!(is_los, link_los(&built, &uav.station, &receiver), "seed {seed}, {k}");
                let (may, does) = (sure.possibly.contains(row, col), sure.surely.contains(row, col));
                let is_within = if is_los { may } else { !does };
                assert!(is_within, "seed {seed}, {k}, ({row}, {col}): {may} {does} {is_los}");
            }
        }
    });
    assert!(count.links > 500, "{count:?}");
}

#[test]
fn redrawn_roofs_of_delft_give_an_interval_around_what_is_known() {
    let field = delft(Roofs::Lod2);
    let site = Site::new("1", (84_550.3, 447_200.7), Height::agl(30.0));
    let uav = Uav::place(&site, &field, None).unwrap();
    let options = MapOptions::default();
    let mapper = Mapper::new(&field, &options).unwrap();
    let errors = HeightErrors::same(1.0, 0.5);
    let redrawn = RedrawnHeights::of(&field, &errors, None, 1).unwrap();
    let counts = mapper.redrawn(std::slice::from_ref(&uav), &redrawn, 60, &Control::default()).unwrap();
    let (low, high) = counts.interval(0, 0.95);
    let (receivers, los) = mapper.seen_from(&uav).unwrap().count();
    let p_los = los as f64 / receivers as f64;
    assert!(low < p_los && p_los < high && high - low < 0.1, "{low} {p_los} {high}");
}

#[test]
fn a_grid_of_receivers_is_that_of_the_roofs() {
    // Cells of roofs are as high as the plane over their centers, rounded up to the lattice.
    let field = delft(Roofs::Lod2);
    let flat = field.with_flat_roofs().unwrap();
    assert_eq!(field.cells().building, flat.cells().building);
    let grid: &GeoRef = field.grid();
    let surfaces = roof_surfaces(&std::fs::read_to_string(DELFT).unwrap());
    let heights = field.surface_m();
    let mut lower = 0;
    for (row, col) in field.cells().building.cells() {
        let (x, y) = grid.world_from_cell(row, col);
        // A ray straight down would have no length in the plane: one that leads a millimeter east.
        let above = |surface: &Surface| surface.clearance([x - 1e-3, y, 500.0], [x + 1e-3, y, 500.0]);
        let wanted = 500.0 - surfaces.iter().map(above).fold(f64::INFINITY, f64::min);
        let found = f64::from(heights[row * grid.n_cols() + col]);
        // Where two roofs meet within a step either may be taken.
        let near = surfaces.iter().any(|s| (500.0 - above(s) - found).abs() < 0.02 + 3.0 * s.off);
        assert!((found - wanted).abs() < 0.02 || near, "row {row}, column {col}: {found} {wanted}");
        lower += u32::from(found < f64::from(flat.surface_m()[row * grid.n_cols() + col]) - 0.1);
        if lower > 2000 {
            break;
        }
    }
    assert!(lower > 2000, "{lower}");
}

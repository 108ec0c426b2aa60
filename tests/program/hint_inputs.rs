//! The files that lines of `tests/hints.txt` name: small scenes and tables, each with one thing that is odd, and good ones.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::plain_tiff::PlainTiff;

/// All of them by name.
pub(crate) fn inputs() -> &'static BTreeMap<&'static str, Vec<u8>> {
    static INPUTS: OnceLock<BTreeMap<&str, Vec<u8>>> = OnceLock::new();
    INPUTS.get_or_init(|| {
        let texts = rasters().into_iter().chain(mosaics()).chain(vectors()).chain(tables());
        texts.map(|(name, text)| (name, text.into_bytes())).chain(tiffs()).chain(clouds()).collect()
    })
}

/// An Esri ASCII grid of `n` × `n` cells.
fn grid(n: usize, (west, south): (f64, f64), cell: f64, height: impl Fn(usize, usize) -> &'static str) -> String {
    let row = |r: usize| (0..n).map(|c| height(r, c)).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..n).map(row).collect();
    format!("ncols {n}\nnrows {n}\nxllcorner {west}\nyllcorner {south}\ncellsize {cell}\n{}\n", rows.join("\n"))
}

/// A wall of a height that is no whole decimeter of the lattice, in the eleventh column.
fn wall(_: usize, c: usize) -> &'static str {
    if c == 10 { "10.3" } else { "0" }
}

/// CityGML of a block of 8 m in a system whose name promises the northing first.
fn northing_first() -> String {
    let square = |z: f64| {
        let corner = |[x, y]: [f64; 2]| format!("{} {} {z}", 5_333_000.0 + y, 4_469_000.0 + x);
        let ring = [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0], [0.0, 0.0]].map(corner).join(" ");
        format!(
            "<gml:surfaceMember><gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>{ring}</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon></gml:surfaceMember>"
        )
    };
    format!(
        "<CityModel xmlns:gml=\"http://www.opengis.net/gml\"><cityObjectMember><Building><lod1Solid><gml:Solid \
         srsName=\"urn:ogc:def:crs:EPSG::31468\">{}{}</gml:Solid></lod1Solid></Building></cityObjectMember></CityModel>",
        square(0.0),
        square(9.0)
    )
}

fn rasters() -> Vec<(&'static str, String)> {
    let walls = |corner| grid(20, corner, 1.0, wall);
    let all = |height: &'static str| grid(20, (0.0, 0.0), 1.0, move |_, _| height);
    let column = |other: &'static str| grid(20, (0.0, 0.0), 1.0, move |_, c| if c == 10 { other } else { "0" });
    let wall_text = walls((0.0, 0.0));
    let short = wall_text.lines().take(23).collect::<Vec<_>>().join("\n");
    let degrees = grid(20, (11.5, 48.1), 0.0001, wall);
    vec![
        ("flat.asc", all("0")),
        ("flat500.asc", all("500")),
        ("void.asc", all("-9999")),
        ("small.asc", grid(10, (0.0, 0.0), 1.0, |_, _| "0")),
        ("hill.asc", grid(20, (0.0, 0.0), 1.0, |_, c| if c == 10 { "12.34" } else { "5" })),
        ("hole.asc", grid(20, (0.0, 0.0), 1.0, |r, c| if r < 10 { "-9999" } else { wall(r, c) })),
        ("odd.asc", column("32767")),
        ("huge.asc", column("1000000000")),
        ("few.asc", short + "\n"),
        ("many.asc", wall_text.clone() + "7 7 7\n"),
        ("wall.asc", wall_text),
        ("wide.asc", grid(100, (0.0, 0.0), 100.0, wall)),
        ("far.asc", walls((5000.0, 0.0))),
        ("real.asc", walls((691_000.0, 5_334_000.0))),
        ("block.asc", walls((691_539.2, 5_334_752.0))),
        ("block2.asc", walls((609.5, 470.0))),
        ("degrees.asc", degrees.clone()),
        // Folders of tiles: in degrees, on two grids, far from each other, and longer than one map.
        ("degrees/a.asc", degrees),
        ("town/a.asc", all("0")),
        ("town/b.asc", walls((20.5, 0.0))),
        ("apart/a.asc", walls((0.0, 0.0))),
        ("apart/b.asc", walls((4200.0, 4200.0))),
        ("long/a.asc", walls((0.0, 0.0))),
        ("long/b.asc", walls((70_000.0, 0.0))),
    ]
}

/// A virtual raster of the wall, placed and put together in some way.
fn vrt(n_cols: usize, head: &str, (attributes, before): (&str, &str), n_sources: usize) -> String {
    let rect = |name: &str| format!(r#"<{name} xOff="0" yOff="0" xSize="20" ySize="20"/>"#);
    let source = format!(
        r#"<SimpleSource><SourceFilename relativeToVRT="1">wall.asc</SourceFilename><SourceBand>1</SourceBand>{}{}</SimpleSource>"#,
        rect("SrcRect"),
        rect("DstRect")
    );
    format!(
        r#"<VRTDataset rasterXSize="{n_cols}" rasterYSize="20">{head}<VRTRasterBand dataType="Float32" band="1"{attributes}>{before}{}</VRTRasterBand></VRTDataset>"#,
        source.repeat(n_sources)
    )
}

fn mosaics() -> Vec<(&'static str, String)> {
    let north_up = "<GeoTransform>0,1,0,20,0,-1</GeoTransform>";
    let turned = "<SRS>EPSG:25832</SRS><GeoTransform>0,0.9,0.3,20,0.3,-0.9</GeoTransform>";
    let sum = (r#" subClass="VRTDerivedRasterBand""#, "<PixelFunctionType>sum</PixelFunctionType>");
    vec![
        ("gaps.vrt", vrt(30, north_up, ("", ""), 1)),
        ("turned.vrt", vrt(20, turned, ("", ""), 1)),
        ("computed.vrt", vrt(20, north_up, sum, 2)),
    ]
}

/// Features, and the reference system that they name, if any.
fn features(crs: Option<&str>, features: &[Value]) -> String {
    let mut collection = json!({"type": "FeatureCollection", "features": features});
    if let Some(crs) = crs {
        collection["crs"] = json!({"type": "name", "properties": {"name": crs}});
    }
    collection.to_string()
}

/// A rectangle from its south-west to its north-east corner.
fn house(properties: &Value, [w, s, e, n]: [f64; 4]) -> Value {
    let ring = [[w, s], [e, s], [e, n], [w, n], [w, s]];
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}})
}

fn point(properties: &Value) -> Value {
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Point", "coordinates": [11, 9]}})
}

/// A house of 10 m × 10 m with a pent roof, above a height of its ground \[m\].
fn pent_roof(ground_m: u32) -> String {
    let corners = [[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [0, 0, 5], [10, 0, 9], [10, 10, 9], [0, 10, 5]];
    let faces = [[0, 3, 2, 1], [0, 1, 5, 4], [2, 3, 7, 6], [1, 2, 6, 5], [3, 0, 4, 7], [4, 5, 6, 7]];
    let faces: Vec<[[u32; 4]; 1]> = faces.into_iter().map(|face| [face]).collect();
    let solid = json!({"type": "Solid", "lod": "2", "boundaries": [faces]});
    json!({
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [1, 1, 1], "translate": [10, 10, ground_m]},
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/25832"},
        "CityObjects": {"a": {"type": "Building", "geometry": [solid]}},
        "vertices": corners,
    })
    .to_string()
}

fn vectors() -> Vec<(&'static str, String)> {
    const UTM: Option<&str> = Some("EPSG:25832");
    const AT: [f64; 4] = [10.0, 10.0, 14.0, 14.0];
    let ten = &json!({"height": 10});
    let in_degrees = house(ten, [11.5, 48.1, 11.5002, 48.1001]);
    let linked = |text: String| {
        text.replace(r#""type":"name""#, r#""type":"link""#).replace(r#""name":"EPSG:25832""#, r#""href":"EPSG:25832""#)
    };
    let no_heights = [
        house(&json!({"height": 10, "tall": 8}), AT),
        house(&json!({"building:levels": 2, "tall": 6}), [20.0, 10.0, 24.0, 14.0]),
        house(&json!({"tall": 6}), [30.0, 10.0, 34.0, 14.0]),
    ];
    let few_heights =
        [house(ten, [0.0, 0.0, 90.0, 90.0]), house(&json!({"building:levels": 2}), [100.0, 0.0, 104.0, 4.0])];
    let top = json!({"top": 512, "foot": 500});
    let tower = json!({"height": 30, "building:part": "yes"});
    let of_3dbag = json!({"b3_h_dak_max": 512, "b3_h_maaiveld": 500});
    let few_tops =
        [house(&json!({"top": 512, "roof": 511}), AT), house(&json!({"roof": 511}), [30.0, 10.0, 34.0, 14.0])];
    let block = |k: u32| f64::from(k) * 30.0;
    let town: Vec<Value> =
        (0..16).map(|k| (block(k % 4), block(k / 4))).map(|(x, y)| house(ten, [x, y, x + 10.0, y + 10.0])).collect();
    vec![
        ("city.geojson", features(UTM, &[house(ten, AT)])),
        ("town.geojson", features(UTM, &town)),
        ("far.geojson", features(UTM, &[house(ten, AT), house(ten, [1e5, 10.0, 1e5 + 4.0, 14.0])])),
        ("none.geojson", features(UTM, &[])),
        ("unnamed.geojson", features(None, &[house(ten, AT)])),
        ("degrees.geojson", features(None, std::slice::from_ref(&in_degrees))),
        ("northing.gml", northing_first()),
        ("lines.geojson", format!("{in_degrees}\n{in_degrees}\n")),
        ("no_heights.geojson", features(UTM, &no_heights)),
        ("few_heights.geojson", features(UTM, &few_heights)),
        ("hoehe.geojson", features(UTM, &[house(&json!({"hoehe": 10}), AT)])),
        ("plain.geojson", features(UTM, &[house(&json!({"name": "Villa"}), AT)])),
        ("bare.geojson", features(UTM, &[house(&json!({}), AT)])),
        ("3dbag.geojson", features(UTM, &[house(&of_3dbag, AT)])),
        ("few_tops.geojson", features(UTM, &few_tops)),
        ("blank.geojson", features(UTM, &[house(&json!({"height": null}), AT)])),
        ("tops.geojson", features(UTM, &[house(&top, AT)])),
        ("parts.geojson", features(UTM, &[house(&json!({"height": 30}), [10.0, 10.0, 18.0, 14.0]), house(&tower, AT)])),
        ("floors.geojson", features(UTM, &[house(&json!({"floors": 3}), AT)])),
        ("unknown_crs.geojson", features(Some("EPSG:999999"), &[house(ten, AT)])),
        ("linked_crs.geojson", linked(features(UTM, &[house(ten, [0.0, 0.0, 40.0, 40.0])]))),
        ("linked_sites.geojson", linked(features(UTM, &[point(&json!({"h": 30}))]))),
        ("far_area.geojson", features(None, &[house(ten, [7e5, 5.3e6, 7e5 + 10.0, 5.3e6 + 10.0])])),
        ("new_zealand.geojson", features(None, &[house(ten, [2_510_010.0, 6_023_160.0, 2_510_014.0, 6_023_164.0])])),
        ("no_height.geojson", features(UTM, &[point(&json!({}))])),
        ("sites.geojson", features(UTM, &[point(&json!({"h": 30, "id": "a", "h_above": "ground"}))])),
        ("house.city.json", pent_roof(0)),
        ("house_high.city.json", pent_roof(500)),
        ("box.obj", "v 5 5 0\nv 15 5 0\nv 15 15 9\nv 5 15 9\nf 1 2 3\nf 1 3 4\n".into()),
    ]
}

fn tables() -> Vec<(&'static str, String)> {
    let many: Vec<String> = (0..40).map(|k| format!("{},{},30\n", k % 5 + 1, k / 5 + 1)).collect();
    let texts = [
        ("sites.csv", "x,y,h\n1,1,30\n3,3,30\n"),
        ("high.csv", "x,y,h\n1,1,100\n3,3,100\n"),
        ("all_columns.csv", "x,y,h,id,h_above\n1,1,30,a,ground\n"),
        ("real_sites.csv", "x,y,h\n691005,5334005,30\n"),
        ("lonlat.csv", "lon,lat,h\n11.56719,48.13066,30\n"),
        ("latlon.csv", "lon,lat,h\n48.13066,11.56719,30\n"),
        ("no_height.csv", "x,y\n1,1\n"),
        ("one_bad.csv", "x,y,h\n1,1,30\n1,here,30\n"),
        ("walk.csv", "x,y\n1,1\n5,5\n"),
        ("lonlat_walk.csv", "lon,lat\n11.56719,48.13066\n11.56714,48.13062\n"),
        ("low_uavs.csv", "id,x,y,h\na,1,1,30\nb,1,1,-5amsl\nc,2,2,-6amsl\n"),
        ("high_walk.csv", "x,y,h\n1,1,3\n5,5,3\n"),
        ("timed_walk.csv", "x,y,h,t\n1,1,3,0\n5,5,3,9\n"),
        ("flight.csv", "x,y,z\n1,1,3\n5,5,3\n"),
        ("no_place.csv", "a,b\n1,1\n"),
        ("curve.csv", "theta_deg,p_los\n10,0.5\n80,0.9\n"),
        ("far_curve.csv", "distance_m,p_los\n10,0.5\n800,0.9\n"),
        ("bad_curve.csv", "theta_deg,p_los\n10,0.5\n80,0.9\nx,y\n"),
        ("no_curve.csv", "theta,p\n1,2\n"),
    ];
    let texts = texts.into_iter().map(|(name, text)| (name, text.to_string()));
    texts.chain([("many.csv", format!("x,y,h\n{}", many.concat()))]).collect()
}

/// Clouds of points in a square of 20 m: without ground, with ground everywhere, with ground in every fourth cell.
fn clouds() -> Vec<(&'static str, Vec<u8>)> {
    let cloud = |class_of: &dyn Fn(i32, i32) -> u8| {
        let mut writer = las::Writer::new(std::io::Cursor::new(Vec::new()), las::Header::default()).expect("a header");
        for (row, col) in (0..20).flat_map(|row| (0..20).map(move |col| (row, col))) {
            let (x, y) = (f64::from(col) + 0.5, f64::from(row) + 0.5);
            let classification = las::point::Classification::new(class_of(row, col)).expect("a class");
            writer.write_point(las::Point { x, y, z: 5.0, classification, ..las::Point::default() }).expect("a point");
        }
        writer.into_inner().expect("bytes").into_inner()
    };
    vec![
        ("unclassified.las", cloud(&|_, _| 1)),
        ("ground.las", cloud(&|_, _| 2)),
        (
            "sparse.las",
            cloud(&|row, col| match (row, col) {
                (19, _) => 6,
                _ if row % 2 == 0 && col % 2 == 0 => 2,
                _ => 1,
            }),
        ),
    ]
}

fn tiffs() -> Vec<(&'static str, Vec<u8>)> {
    let plain = || PlainTiff::floats((691_000.0, 5_334_020.0), 1.0, 20, vec![3.0; 400]).bytes();
    let bytes_of = |numbers: &[u16]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let with = |from: &[u16], to: &[u16]| {
        let (mut file, from) = (plain(), bytes_of(from));
        let at = file.windows(from.len()).position(|window| window == from).expect("numbers of a plain GeoTIFF");
        file[at..at + from.len()].copy_from_slice(&bytes_of(to));
        file
    };
    // In place of the raster type the system of heights.
    let above = |system: u16| with(&[1025, 0, 1, 1, 3072, 0, 1, 25832], &[3072, 0, 1, 25832, 4096, 0, 1, system]);
    vec![
        ("on_ellipsoid.tif", above(4979)),
        ("on_datum.tif", above(5703)),
        // A tie point, and a tag that nobody knows in place of the cell size.
        ("nowhere.tif", with(&[33550, 12, 3, 0], &[33551, 12, 3, 0])),
    ]
}

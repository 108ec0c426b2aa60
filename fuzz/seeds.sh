#!/usr/bin/env bash
# Small good files of every kind as seeds: fuzz/corpus/TARGET. Needs a built skyshed; what GDAL writes is added where it is.
set -euo pipefail
cd "$(dirname "$0")"
skyshed=$(realpath "${SKYSHED:-../target/release/skyshed}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
put() { mkdir -p "corpus/$1" && cp "$2" "corpus/$1/seed-${3:-$(basename "$2")}"; }

pushd "$work" >/dev/null
"$skyshed" city itu:urban --size 60 --cell 4 -o city.geojson -o city.tif -o city.asc -q
"$skyshed" map itu:urban --size 60 --cell 4 --uav 5,5,80 --layers los,margin --tif-layout plain -o plain.tif -q
"$skyshed" map itu:urban --size 60 --cell 4 --uav 5,5,80 -o mask.tif -q
cat > osm.geojson <<'J'
{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, "features": [
 {"type": "Feature", "id": 1, "properties": {"height": 12.5}, "geometry": {"type": "Polygon", "coordinates":
  [[[10, 10], [30, 10], [30, 25], [10, 25], [10, 10]], [[15, 14], [15, 20], [22, 20], [22, 14], [15, 14]]]}},
 {"type": "Feature", "properties": {"height": "8,5", "building:levels": 3, "building:part": "yes"}, "geometry":
  {"type": "MultiPolygon", "coordinates": [[[[40, 10], [50, 12.25], [44, 30], [40, 10]]], [[[5, 40], [20, 41], [12, 50]]]]}}]}
J
cat > house.city.json <<'J'
{"type": "CityJSON", "version": "2.0", "transform": {"scale": [0.5, 0.5, 0.5], "translate": [0, 0, 0]},
 "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/7415"}, "CityObjects": {"a": {"type": "Building",
 "attributes": {"height": 9}, "geometry": [{"type": "Solid", "lod": "1", "boundaries": [[[[0, 3, 2, 1]], [[4, 5, 6, 7]],
 [[0, 1, 5, 4]], [[1, 2, 6, 5]], [[2, 3, 7, 6]], [[3, 0, 4, 7]]]]}]}},
 "vertices": [[20, 20, 0], [40, 20, 0], [40, 40, 0], [20, 40, 0], [20, 20, 18], [40, 20, 18], [40, 40, 18], [20, 40, 18]]}
J
printf 'o a\nv 10 10 0\nv 30 10 0\nv 30 20 9\nv 10 20 9.5\nf 1 2 3\nf 1/1/1 3//2 -1\nf 1 2 3 4\n' > roof.obj
printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n10 10 0\n30 10 0\n30 20 9\n10 20 9.5\n4 0 1 2 3\n' > roof.ply
printf 'id,x,y,h,h_above\na,691005,5334950,60,ground\nb,691035.5,5334980,90,amsl\n"c d",691012,5334966,20roof,\n' > places.csv
printf 'lon,lat,h\n11.58,48.14,120agl\n' > degrees.csv
cat > places.geojson <<'J'
{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"h": 60, "id": "a", "h_above": "roof"},
 "geometry": {"type": "Point", "coordinates": [11.58, 48.14]}}]}
J
printf '#x,y\n691001,5334950\n691020,5334951\n' > walk.csv
printf '{{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[11.58, 48.14], [11.59, 48.15]]}}' > walk.json
cat > mosaic.vrt <<'V'
<VRTDataset rasterXSize="4" rasterYSize="3"><SRS>EPSG:25832</SRS><GeoTransform>0, 1, 0, 3, 0, -1</GeoTransform>
<VRTRasterBand dataType="Float32" band="1"><NoDataValue>-9</NoDataValue><SimpleSource>
<SourceFilename relativeToVRT="1">tile.asc</SourceFilename><SourceBand>1</SourceBand><SrcRect xOff="0" yOff="0" xSize="3" ySize="2"/>
<DstRect xOff="0" yOff="1" xSize="3" ySize="2"/></SimpleSource><ComplexSource><SourceFilename relativeToVRT="1">tile.asc</SourceFilename>
<SrcRect xOff="1" yOff="0" xSize="2" ySize="2"/><DstRect xOff="2" yOff="0" xSize="2" ySize="2"/><ScaleOffset>1</ScaleOffset>
<ScaleRatio>2</ScaleRatio><NODATA>2</NODATA></ComplexSource></VRTRasterBand></VRTDataset>
V
if command -v ogr2ogr >/dev/null; then
  ogr2ogr -f FlatGeobuf city.fgb osm.geojson -nlt MULTIPOLYGON 2>/dev/null
  ogr2ogr -f FlatGeobuf flat.fgb osm.geojson -nlt MULTIPOLYGON -lco SPATIAL_INDEX=NO 2>/dev/null
  ogr2ogr -f GPKG city.gpkg osm.geojson -nlt MULTIPOLYGON 2>/dev/null
  ogr2ogr -f "ESRI Shapefile" city.shp osm.geojson -nlt POLYGON 2>/dev/null
  python3 - <<'P'
import struct
shp, dbf = open("city.shp", "rb").read(), open("city.dbf", "rb").read()
open("shapes", "wb").write(struct.pack("<I", len(shp)) + shp + dbf)
P
  for kind in LZW DEFLATE ZSTD LERC JPEG; do
    gdal_translate -q -co COMPRESS=$kind -co TILED=YES -ot $([ $kind = JPEG ] && echo Byte || echo Float32) city.tif $kind.tif || rm -f $kind.tif
  done
  gdal_translate -q -co COMPRESS=DEFLATE -co PREDICTOR=3 city.tif predictor.tif
  gdal_translate -q -a_srs EPSG:25832+5783 -ot Int16 city.tif datum.tif
fi
for name in 'EPSG:25832' 'urn:ogc:def:crs:OGC:1.3:CRS84' 'EPSG:25832+5783' '+proj=utm +zone=32 +ellps=GRS80 +units=m +no_defs' \
  'PROJCS["a",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["False_Easting",500000.0],UNIT["Meter",1.0]]'; do
  printf '%s' "$name" > "crs-$(printf '%s' "$name" | cksum | cut -d' ' -f1)"
done
printf '39'"'"'4"' > number-feet; printf '12,5 m' > number-comma; printf '120agl' > number-agl; printf 'itu:0.3,500,15' > number-itu
popd >/dev/null

for file in "$work"/*.tif; do put geotiff "$file"; done
put ascii_grid "$work/city.asc"
put virtual_raster "$work/mosaic.vrt"
put area "$work/osm.geojson"
for file in "$work"/city.geojson "$work"/osm.geojson; do put geojson "$file"; done
put cityjson "$work/house.city.json"
put obj "$work/roof.obj"
put ply "$work/roof.ply"
for file in "$work"/places.csv "$work"/degrees.csv; do put sites_csv "$file"; done
put sites_geojson "$work/places.geojson"
for file in "$work"/walk.csv "$work"/walk.json; do put track "$file"; done
for file in "$work"/crs-*; do put crs "$file"; done
for file in "$work"/number-*; do put numbers "$file"; done
if [ -e "$work/shapes" ]; then
  for file in "$work"/*.fgb; do put flatgeobuf "$file"; done
  put geopackage "$work/city.gpkg"
  put shapefile "$work/shapes"
fi

#!/usr/bin/env bash
# Small good files of every kind as seeds: fuzz/corpus/TARGET. The tests make most of them; what GDAL writes is added where it is.
set -euo pipefail
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
SKYSHED_SEEDS=$work cargo test --release --locked --manifest-path ../Cargo.toml --test files -- --exact fuzz::good_files_are_seeds
put() { mkdir -p "corpus/$1" && cp "$2" "corpus/$1/seed-${3:-$(basename "$2")}"; }

pushd "$work" >/dev/null
printf 'id,x,y,h,h_above\na,691005,5334950,60,ground\nb,691035.5,5334980,90,amsl\n"c d",691012,5334966,20roof,\n' > places.csv
printf 'lon,lat,h\n11.58,48.14,120agl\n' > degrees.csv
printf '#x,y\n691001,5334950\n691020,5334951\n' > walk.csv
printf '{{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[11.58, 48.14], [11.59, 48.15]]}}' > walk.json
# Two files as one: the length of the first in four bytes.
n=$(stat -c %s town.shp)
for k in 0 8 16 24; do printf "\\x$(printf %02x $((n >> k & 255)))"; done > shapes
cat town.shp town.dbf >> shapes
if command -v gdal_translate >/dev/null; then
  for kind in LZW DEFLATE ZSTD LERC JPEG; do
    gdal_translate -q -co COMPRESS=$kind -co TILED=YES -ot $([ $kind = JPEG ] && echo Byte || echo Float32) surface.tif $kind.tif || rm -f $kind.tif
  done
  gdal_translate -q -co COMPRESS=DEFLATE -co PREDICTOR=3 surface.tif predictor.tif
  gdal_translate -q -a_srs EPSG:25832+5783 -ot Int16 surface.tif datum.tif
fi
for name in 'EPSG:25832' 'urn:ogc:def:crs:OGC:1.3:CRS84' 'EPSG:25832+5783' '+proj=utm +zone=32 +ellps=GRS80 +units=m +no_defs' \
  'PROJCS["a",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["False_Easting",500000.0],UNIT["Meter",1.0]]'; do
  printf '%s' "$name" > "crs-$(printf '%s' "$name" | cksum | cut -d' ' -f1)"
done
printf '39'"'"'4"' > number-feet; printf '12,5 m' > number-comma; printf '120agl' > number-agl; printf 'itu:0.3,500,15' > number-itu
popd >/dev/null

for file in "$work"/*.tif; do put geotiff "$file"; done
put ascii_grid "$work/grid.asc"
put virtual_raster "$work/mosaic.vrt"
put xyz "$work/grid.xyz"
for file in "$work"/town.la[sz] ${SKYSHED_TRUTH:+"$SKYSHED_TRUTH"/formats/lidar/pdal.copc.laz}; do put point_cloud "$file"; done
put area "$work/area.geojson"
for file in "$work"/city.geojson "$work"/lines.geojsonl; do put geojson "$file"; done
put cityjson "$work/town.city.json"
for file in "$work"/*.gml; do put citygml "$file"; done
for file in "$work"/*.parquet; do put geoparquet "$file"; done
for file in "$work"/town.osm* "$work"/nodes.json "$work"/places.json; do put osm "$file"; done
for file in "$work"/town.zip "$work"/*.gz; do put packed "$file"; done
for file in "$work"/*.fgb; do put flatgeobuf "$file"; done
put geopackage "$work/town.gpkg"
put shapefile "$work/shapes"
put obj "$work/town.obj"
for file in "$work"/*.ply; do put ply "$file"; done
for file in "$work"/places.csv "$work"/degrees.csv "$work"/sites.csv; do put sites_csv "$file"; done
put sites_geojson "$work/sites.geojson"
for file in "$work"/walk.csv "$work"/walk.json; do put track "$file"; done
for file in "$work"/crs-*; do put crs "$file"; done
for file in "$work"/number-*; do put numbers "$file"; done

"""What PROJ makes of longitude and latitude in reference systems of many names: prints tests/systems.csv.

    pip install pyproj==3.7.2
    python tests/tools/systems.py > tests/systems.csv

Places are compared within 1 cm. Where the registry has several operations without a grid, PROJ and proj-core may take
different ones: then within the published accuracy of PROJ's.
"""

import pyproj
from pyproj import Transformer
from pyproj.transformer import TransformerGroup

pyproj.network.set_network_enabled(False)
# name as typed, code for PROJ, five places
NRW = [(6.1, 50.8), (6.96, 50.94), (7.6, 51.96), (8.5, 51.7), (9.4, 51.4)]
BY = [(11.58, 48.14), (11.0, 49.4), (12.1, 49.0), (10.9, 48.4), (13.0, 48.5)]
BE = [(13.4, 52.52), (13.0, 52.4), (12.2, 51.9), (13.7, 51.05), (14.9, 52.3)]
RP = [(6.2, 49.8), (6.7, 50.2), (7.0, 51.4), (6.8, 51.2), (6.1, 50.8)]


def around(lon, lat, d=0.3):
    """A place and four around it [deg]."""
    steps = [(0, 0), (d, d / 3), (-d / 2, d / 2), (d / 3, -d / 2), (-d, -d / 3)]
    return [(round(lon + east, 4), round(lat + north, 4)) for east, north in steps]


ROWS = [
    ("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", 25832, NRW),
    ("ETRS89_UTM31", 25831, around(5.0, 51.0)),
    ("urn:adv:crs:ETRS89_UTM33*DE_DHHN92_NH", 25833, BE),
    ("DE_DHDN_3GK2", 31466, RP),
    ("urn:adv:crs:DE_DHDN_3GK3", 31467, around(9.18, 48.78)),
    ("urn:adv:crs:DE_DHDN_3GK4*DE_DHHN12_NOH", 31468, BY),
    ("DE_DHDN_3GK5", 31469, around(14.5, 51.2)),
    ("http://www.opengis.net/gml/srs/epsg.xml#25832", 25832, BY),
    (
        "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/28992&2=http://www.opengis.net/def/crs/EPSG/0/5709",
        28992,
        around(4.9, 52.37),
    ),
    ("urn:ogc:def:crs,crs:EPSG:6.12:25833,crs:EPSG:6.12:5783", 25833, BE),
    ("EPSG:25830+5782", 25830, around(-3.7, 40.4)),
    ("EPSG:3857", 3857, [(10.75, 59.91), (-0.1, 51.5), (-70.6, -33.4), (103.8, 1.3), (179.9, -16.8)]),
    ("ESRI:102100", 3857, around(10.75, 59.91)),
    ("EPSG:4547", 4547, around(114.0, 33.48)),
    ("EPSG:4490", 4490, around(116.4, 39.9)),
    ("EPSG:4513", 4513, around(75.0, 39.5)),
    ("EPSG:4526", 4526, around(114.3, 30.6)),
    ("EPSG:4497", 4497, around(104.0, 30.7)),
    ("EPSG:7856", 7856, around(151.2, -33.87)),
    ("EPSG:7844", 7844, around(144.96, -37.81)),
    ("EPSG:7850", 7850, around(115.86, -31.95)),
    ("EPSG:28356", 28356, around(151.2, -33.87)),
    ("EPSG:32760", 32760, [(179.95, -16.8), (179.999, -16.7), (-179.99, -16.8), (-179.9, -17.0), (178.0, -18.0)]),
    ("EPSG:32701", 32701, [(-179.95, -16.8), (179.999, -16.7), (179.9, -16.8), (-178.0, -17.0), (-177.0, -18.0)]),
    ("EPSG:27700", 27700, around(-1.5, 52.5)),
    ("EPSG:2154", 2154, around(2.35, 48.86)),
    ("EPSG:2056", 2056, around(8.54, 47.1)),
    ("EPSG:31370", 31370, around(4.35, 50.85, 0.1)),
    ("EPSG:3035", 3035, around(9.18, 48.78)),
    ("EPSG:5514", 5514, around(14.42, 50.0)),
    ("EPSG:2180", 2180, around(21.0, 52.2)),
    ("EPSG:3006", 3006, around(18.07, 59.33)),
    ("EPSG:2263", 2263, around(-73.9, 40.72, 0.1)),
    ("EPSG:6677", 6677, around(139.7, 35.7)),
    ("EPSG:2193", 2193, around(174.76, -36.85)),
    ("EPSG:5179", 5179, around(127.0, 37.5)),
    ("EPSG:31983", 31983, around(-43.2, -22.5)),
    ("EPSG:3414", 3414, around(103.8, 1.33, 0.1)),
    ("EPSG:2326", 2326, around(114.1, 22.35, 0.1)),
    ("EPSG:3826", 3826, around(121.5, 25.0)),
    ("EPSG:6372", 6372, around(-99.1, 19.4)),
    ("EPSG:3067", 3067, around(24.9, 60.3)),
]
# Systems in which PROJ and proj-core take different operations.
OTHER_OPERATIONS = {31469, 31370, 5514}

print("name,lon,lat,x,y,within_m")
for name, code, places in ROWS:
    to = Transformer.from_crs(4326, code, always_xy=True)
    within = TransformerGroup(4326, code, always_xy=True).transformers[0].accuracy if code in OTHER_OPERATIONS else 0.01
    for lon, lat in places:
        x, y = to.transform(lon, lat)
        print(f'"{name}",{lon},{lat},{x:.8f},{y:.8f},{within}')

"""Line of sight by Mitsuba's ray tracer against a mask of skyshed.

    skyshed city SCENE -o city.xml
    skyshed map SCENE --uav X,Y,H -o mask.npz
    python3 tests/tools/mitsuba_agreement.py city.xml mask.npz [GROUND]

Sends a ray from every receiver to the UAV and prints one JSON object: the receivers, how many of them agree, and the share.
The meshes have 32 bits and so has the tracer, so a ray that grazes a wall may go either way. The ground is flat, at GROUND m
above the datum or at 0 m.
"""

import json
import sys

import mitsuba as mi
import numpy as np


def variant():
    """The first variant that works here: LLVM traces all rays at once, the scalar one a ray at a time."""
    for name in ("llvm_ad_rgb", "scalar_rgb"):
        try:
            mi.set_variant(name)
            mi.load_dict({"type": "sphere"})
            return name
        except Exception:  # a variant without its library raises what it likes
            continue
    sys.exit("no variant of Mitsuba works here")


def blocked(scene, origins, target, name):
    """Whether something lies between each origin and the target."""
    directions = target - origins
    if name == "scalar_rgb":
        rays = (mi.Ray3f(o, d, 1.0, 0.0, mi.Color0f()) for o, d in zip(origins.tolist(), directions.tolist()))
        return np.fromiter((scene.ray_test(ray) for ray in rays), bool, len(origins))
    ray = mi.Ray3f(mi.Point3f(*origins.T.astype(np.float32)), mi.Vector3f(*directions.T.astype(np.float32)))
    ray.maxt = 1.0
    return np.array(scene.ray_test(ray))


def main():
    scene_file, mask_file = sys.argv[1:3]
    ground = float(sys.argv[3]) if len(sys.argv) > 3 else 0.0
    mask = np.load(mask_file)
    meta = json.loads(str(mask["meta"]))
    origin = json.load(open(scene_file + ".json", encoding="utf-8"))["mesh"]["origin"]
    rows, cols = np.nonzero(mask["los"][0] <= 1)
    expected = mask["los"][0][rows, cols] == 1
    heights = np.full(len(rows), ground + meta["rx_height_m"])
    origins = np.stack([mask["x"][cols] - origin[0], mask["y"][rows] - origin[1], heights], axis=1)
    uav = mask["sites"][0] - [origin[0], origin[1], 0.0]
    name = variant()
    seen = ~blocked(mi.load_file(scene_file), origins, uav, name)
    agree = int((seen == expected).sum())
    print(json.dumps({"variant": name, "receivers": len(rows), "agree": agree, "share": agree / len(rows)}))


if __name__ == "__main__":
    main()

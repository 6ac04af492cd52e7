#!/usr/bin/env python3
"""Lets GDAL read what io.write_geotiff writes, in every combination of its options.

Needs Python with rasterio, and is no part of the tests. Run it in the repository's root after a change to the writer:

    cargo build && python3 nodes/tests/gdal_read_back.py target/debug/orograph
"""

import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import rasterio
from rasterio.transform import Affine

NODATA = {"float32": -32768, "int16": -32768, "uint16": 65535}
PLACES = {
    "utm": ("EPSG:32633", Affine(30, 0, 500000, 0, -30, 4600000)),
    "degrees": ("EPSG:4326", Affine(0.001, 0, 7, 0, -0.002, 46)),
    "feet": ("EPSG:2225", Affine(100, 0, 6e6, 0, -100, 2e6)),
    "rotated": ("EPSG:32633", Affine(24, 18, 500000, 18, -24, 4600000)),
    "own": ("+proj=lcc +lat_1=40 +lat_2=42 +lat_0=39 +lon_0=-96 +datum=NAD83 +units=m", Affine(30, 0, 6e5, 0, -30, 2e5)),
}


def main(orograph: str) -> int:
    rng = np.random.default_rng(1)
    heights = rng.integers(0, 4000, (300, 270)).astype("float32")
    heights[rng.random(heights.shape) < 0.1] = np.nan
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        nodes, expected = [], {}
        for place, (crs, transform) in PLACES.items():
            with rasterio.open(
                f"{folder}/{place}.tif", "w", driver="GTiff", height=heights.shape[0], width=heights.shape[1],
                count=1, dtype="float32", nodata=float("nan"), crs=crs, transform=transform,
            ) as source:
                source.write(heights, 1)
            nodes.append(f'"{place}": (node: "io.read_dem", version: 1, params: (file: "{place}.tif")),')
            options = itertools.product(NODATA, ("deflate", "lzw", "none"), ("tiles", "strips"), (1, 9))
            for sample, compression, layout, level in options:
                name = f"{place}_{sample}_{compression}_{layout}_{level}"
                nodes.append(
                    f'"{name}": (node: "io.write_geotiff", version: 1, inputs: {{"terrain": "{place}.terrain"}},'
                    f' params: (file: "{name}.tif", sample: "{sample}", compression: "{compression}",'
                    f' layout: "{layout}", level: {level}, nodata: {NODATA[sample]}.0)),'
                )
                expected[name] = (place, sample, compression, layout)
        Path(folder, "g.ron").write_text("(format: 1, nodes: {" + "\n".join(nodes) + "})")
        subprocess.run(
            [orograph, "run", "g.ron", "--cache", "none", "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL
        )
        for name, (place, sample, compression, layout) in expected.items():
            with rasterio.open(f"{folder}/{place}.tif") as source, rasterio.open(f"{folder}/out/{name}.tif") as found:
                data = found.read(1, masked=True).astype("float32").filled(np.nan)
                checks = {
                    "heights": np.array_equal(data, heights, equal_nan=True),
                    "type": found.dtypes[0] == sample,
                    "nodata": found.nodata == NODATA[sample],
                    "transform": found.transform.almost_equals(source.transform, 1e-9),
                    "system": found.crs == source.crs,
                    "compression": (found.compression.value if found.compression else "NONE").lower() == compression,
                    "layout": found.profile["tiled"] == (layout == "tiles"),
                    "area": found.tags().get("AREA_OR_POINT") == "Area",
                }
            wrong = [what for what, holds in checks.items() if not holds]
            if wrong:
                faults += 1
                print(f"{name}: {', '.join(wrong)}")
    print(f"{len(expected)} files, {faults} with faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(str(Path(sys.argv[1]).resolve())))

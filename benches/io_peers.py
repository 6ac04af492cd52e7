"""The peers of nodes/benches/io.rs: GDAL (through rasterio) and OpenCV, on the same 4097 x 4097 terrain.

Prints megabytes of raw samples per second of CPU time, best of five. Needs numpy, rasterio and opencv-python;
OROGRAPH_DEM_DIR (default ../shared/dem) must hold the terrain that the benchmark uses.
"""

import os
import tempfile
import time

import cv2
import numpy as np
import rasterio

SIDE = 4097


def terrain():
    folder = os.environ.get("OROGRAPH_DEM_DIR", "../shared/dem")
    with rasterio.open(os.path.join(folder, "half_dome_yosemite_ned1as_1027x875.tif")) as file:
        heights = file.read(1).astype(np.float32)
    rows, cols = heights.shape
    return np.pad(heights, ((0, SIDE - rows), (0, SIDE - cols)), mode="symmetric")


def best(what, size, work):
    seconds = []
    for _ in range(5):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    print(f"{what}: {size / 1e6 / min(seconds):.0f} MB/s")


def geotiff(path, samples, predictor):
    profile = dict(driver="GTiff", width=SIDE, height=SIDE, count=1, dtype=samples.dtype, tiled=True,
                   blockxsize=256, blockysize=256, compress="deflate", zlevel=1, predictor=predictor)

    def write():
        with rasterio.open(path, "w", **profile) as file:
            file.write(samples, 1)

    def read():
        with rasterio.open(path) as file:
            return file.read(1)

    name = f"GDAL {samples.dtype}"
    best(f"{name} write", samples.nbytes, write)
    best(f"{name} read", samples.nbytes, read)


def png(path, samples):
    best("OpenCV PNG write", samples.nbytes, lambda: cv2.imwrite(path, samples))
    best("OpenCV PNG read", samples.nbytes, lambda: cv2.imread(path, cv2.IMREAD_UNCHANGED))


def main():
    heights = terrain()
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        geotiff(os.path.join(folder, "int16.tif"), np.rint(heights).astype(np.int16), 2)
        geotiff(os.path.join(folder, "float32.tif"), heights, 3)
        levels = (np.clip(heights / 4000, 0, 1) * 65535 + 0.5).astype(np.uint16)
        png(os.path.join(folder, "grey.png"), levels)


main()

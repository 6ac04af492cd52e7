"""Voids of real terrain filled by other tools and by `repair.void_patch`, in one run.

Usage: python3 benches/void_peers.py TERRAIN... with numpy, scipy, rasterio and opencv; OROGRAPH names the command.
For each terrain: the error in voids, roughness (standard deviation of the Laplacian) relative to the truth in voids and
within two cells of their rim, the mean step across the rim relative to that just outside, and seconds.
"""

import os
import subprocess
import sys
import tempfile
import time

import cv2
import numpy as np
import rasterio
import rasterio.fill
from scipy import ndimage

OROGRAPH = os.environ.get("OROGRAPH", "target/release/orograph")

GRAPH = """(format: 1, nodes: {{
    "dem": (node: "io.read_dem", version: 1, params: (file: "{file}")),
    "blots": (node: "mask.random_voids", version: 1,
        params: (share: 0.05, smallest: {smallest}, largest: {largest}, seed: 3), inputs: {{"like": "dem.terrain"}}),
    "tile": (node: "adjust.punch", version: 1, inputs: {{"terrain": "dem.terrain", "mask": "blots.mask"}}),
    "patch": (node: "repair.void_patch", version: 1, inputs: {{"terrain": "tile.terrain"}}),
    "plate": (node: "repair.thin_plate_fill", version: 1, inputs: {{"terrain": "tile.terrain"}}),
    "write_tile": (node: "io.write_geotiff", version: 1, params: (file: "tile.tif"), inputs: {{"terrain": "tile.terrain"}}),
    "write_truth": (node: "io.write_geotiff", version: 1, params: (file: "truth.tif"), inputs: {{"terrain": "dem.terrain"}}),
    "write_patch": (node: "io.write_geotiff", version: 1, params: (file: "patch.tif"), inputs: {{"terrain": "patch.terrain"}}),
    "write_plate": (node: "io.write_geotiff", version: 1, params: (file: "plate.tif"), inputs: {{"terrain": "plate.terrain"}}),
}})"""


def read(path):
    with rasterio.open(path) as file:
        data = file.read(1).astype(np.float64)
        data[data == file.nodata] = np.nan
        return data


def figures(filled, truth, void):
    error = (filled - truth)[void]
    around = ndimage.binary_dilation(void, np.ones((5, 5))) & ~ndimage.binary_erosion(void, np.ones((5, 5)))

    def roughness(where):
        pair = [ndimage.laplace(field)[where & inner] for field in (filled, truth)]
        return np.nanstd(pair[0]) / np.nanstd(pair[1])

    inner = np.zeros_like(void)
    inner[1:-1, 1:-1] = True
    collar = ndimage.binary_dilation(void, np.ones((9, 9)))
    edge, outside = [], []
    for axis in (0, 1):
        step = np.abs(np.diff(filled, axis=axis))
        a, b = (np.take(void, range(k, void.shape[axis] - 1 + k), axis) for k in (0, 1))
        near = np.take(collar, range(0, void.shape[axis] - 1), axis) & np.take(collar, range(1, void.shape[axis]), axis)
        edge.append(step[a != b])
        outside.append(step[near & ~a & ~b])
    step = np.nanmean(np.concatenate(edge)) / np.nanmean(np.concatenate(outside))
    return np.sqrt(np.mean(error**2)), roughness(void), roughness(around), step


def peers(tile, void):
    known = (~void).astype(np.uint8)
    for smoothing in (0, 3):
        started = time.perf_counter()
        filled = rasterio.fill.fillnodata(
            np.nan_to_num(tile).astype(np.float32), known, max_search_distance=400, smoothing_iterations=smoothing
        )
        yield f"GDAL fill, {smoothing} smoothings", filled.astype(np.float64), time.perf_counter() - started
    low, high = np.nanmin(tile), np.nanmax(tile)
    grey = np.nan_to_num((tile - low) / (high - low) * 65535).astype(np.uint16)
    started = time.perf_counter()
    filled = cv2.inpaint(grey, void.astype(np.uint8), 3, cv2.INPAINT_NS).astype(np.float64) / 65535 * (high - low) + low
    yield "OpenCV inpaint", filled, time.perf_counter() - started


def main():
    for file in sys.argv[1:]:
        with rasterio.open(file) as opened:
            side = abs(opened.transform.a) * (111_320 if opened.crs and opened.crs.is_geographic else 1)
        with tempfile.TemporaryDirectory() as folder:
            graph = os.path.join(folder, "g.ron")
            with open(graph, "w", encoding="utf-8") as out:
                out.write(GRAPH.format(file=os.path.abspath(file), smallest=20 * side, largest=200 * side))
            made = subprocess.run(
                [OROGRAPH, "run", graph, "--cache", "none", "--out", folder, "--timings"],
                check=True, capture_output=True, text=True,
            )
            took = {}
            for line in made.stderr.splitlines():
                words = line.split()
                if len(words) > 3 and words[1] == "ms":
                    took[words[-2]] = float(words[0]) / 1000
            tile, truth, patch, plate = (read(os.path.join(folder, f"{name}.tif")) for name in ("tile", "truth", "patch", "plate"))
        void = np.isnan(tile) & ~np.isnan(truth)
        print(f"{os.path.basename(file)}: {void.sum()} void cells")
        rows = [("void_patch", patch, took.get("patch", np.nan)), ("thin plate", plate, took.get("plate", np.nan))]
        for name, filled, seconds in rows + list(peers(tile, void)):
            error, rough, rim, step = figures(filled, truth, void)
            print(f"  {name:24} error {error:7.1f} m  roughness {rough:5.2f}  rim {rim:5.2f}  step {step:5.2f}  {seconds:6.2f} s")


if __name__ == "__main__":
    main()

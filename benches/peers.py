"""Our benchmarks beside named peers, in one run: one table of ratios.

    pip install numpy scipy opencv-python-headless PyMaxflow rasterio pyamg
    python3 benches/peers.py [NAME…]

For each row the benchmark of this repository runs on one thread, then the peer on one thread; both give the best of some
runs. A ratio below 1 means that ours is quicker. Peers that are not installed are named and left out. The rows of
io_peers.py, numpy_chain.py and void_peers.py, which need data or compare more than time, stay there.
"""

import importlib
import os
import re
import subprocess
import sys
import time

UNITS = {"ns": 1e-9, "µs": 1e-6, "ms": 1e-3, "s": 1.0}


def ours(package, bench, name, argument):
    """The fastest run of a benchmark, in seconds."""
    command = ["cargo", "bench", "--quiet", "-p", package, "--bench", bench, "--", "--sample-count", "5", name]
    environment = dict(os.environ, RAYON_NUM_THREADS="1")
    text = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        label = re.split(r"\s{2,}|│", re.sub(r"^[\s│├╰─]+", "", line))[0].strip()
        found = re.search(r"([\d.]+) (ns|µs|ms|s)\b", line)
        if found and (label == argument or label.startswith(argument + " ")):
            return float(found[1]) * UNITS[found[2]]
    raise SystemExit(f"no line {argument!r} from {' '.join(command)}:\n{text}")


def best(work, runs=5):
    seconds = []
    for _ in range(runs):
        begun = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


def noise(side, seed=1):
    """Rough ground, as single precision."""
    import numpy as np

    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal((side, side)))
    y, x = np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None, :]
    ground = np.fft.irfft2(spectrum / np.maximum(np.hypot(y, x), 1 / side) ** 1.8, s=(side, side))
    return ((ground - ground.min()) / np.ptp(ground) * 2000).astype(np.float32)


def opencv():
    import cv2

    cv2.setNumThreads(1)
    return cv2


def blur():
    ground, cv2 = noise(1024), opencv()
    # The node's default of 100 m on cells of 23.7 by 30.9 m, out to four deviations.
    size = lambda sigma: 2 * int(-(-4 * sigma // 1)) + 1
    x, y = 100 / 23.7, 100 / 30.9
    return best(lambda: cv2.GaussianBlur(ground, (size(x), size(y)), sigmaX=x, sigmaY=y))


def median():
    ground, cv2 = noise(1024), opencv()
    return best(lambda: cv2.medianBlur(ground, 3))


def distance():
    from scipy import ndimage
    import numpy as np

    cells = np.arange(1024 * 1024).reshape(1024, 1024) % 6
    outside = np.isin(cells, [0, 1, 2])
    return best(lambda: ndimage.distance_transform_edt(outside, sampling=(30.9, 23.7)), 3)


def maxflow_cut(rows, cols):
    import maxflow
    import numpy as np

    old, new = noise(max(rows, cols), 1)[:rows, :cols], noise(max(rows, cols), 2)[:rows, :cols]
    apart = np.abs(old - new).astype(np.float64)
    def work():
        graph = maxflow.Graph[float](rows * cols, 2 * rows * cols)
        nodes = graph.add_grid_nodes((rows, cols))
        down = np.zeros((rows, cols)); down[:-1] = apart[:-1] + apart[1:]
        across = np.zeros((rows, cols)); across[:, :-1] = apart[:, :-1] + apart[:, 1:]
        graph.add_grid_edges(nodes, down, structure=np.array([[0, 0, 0], [0, 0, 0], [0, 1, 0]]), symmetric=True)
        graph.add_grid_edges(nodes, across, structure=np.array([[0, 0, 0], [0, 0, 1], [0, 0, 0]]), symmetric=True)
        much = 1e12
        graph.add_grid_tedges(nodes[:, 0], much, 0)
        graph.add_grid_tedges(nodes[:, -1], 0, much)
        graph.maxflow()
    return best(work, 3)


def sine_poisson(side):
    from scipy import fft
    import numpy as np

    b = np.zeros((side, side)); b[:, side // 2] = 10
    k = np.arange(1, side + 1)
    ring = 2 * np.cos(np.pi * k / (side + 1)) - 2
    def work():
        spectrum = fft.dstn(b, type=1, workers=1)
        spectrum /= ring[:, None] + ring[None, :]
        return fft.idstn(spectrum, type=1, workers=1)
    return best(work)


def multigrid_disc(side):
    import numpy as np
    import pyamg
    from scipy import sparse

    y, x = np.mgrid[:side, :side]
    free = np.hypot(y - side / 2, x - side / 2) < side / 2 - 2
    number = np.full((side, side), -1); number[free] = np.arange(free.sum())
    n = free.sum()
    rows, cols = [], []
    for a, b in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:])):
        both = (a >= 0) & (b >= 0)
        rows += [a[both], b[both]]; cols += [b[both], a[both]]
    rows, cols = np.concatenate(rows), np.concatenate(cols)
    matrix = sparse.csr_matrix((-np.ones(len(rows)), (rows, cols)), (n, n)) + 4 * sparse.eye(n)
    b = np.zeros((side, side)); b[:, side // 2] = 10
    wanted = -b[free]
    def work():
        solver = pyamg.ruge_stuben_solver(matrix.tocsr())
        return solver.solve(wanted, tol=1e-6, accel="cg")
    return best(work, 2)


def gradient(kind):
    import numpy as np
    from scipy import ndimage

    ground = noise(1024).astype(np.float32)
    def work():
        # Horn's gradient, as gdaldem has it, which rasterio does not carry.
        east = ndimage.sobel(ground, axis=1) / (8 * 23.7)
        south = ndimage.sobel(ground, axis=0) / (8 * 30.9)
        if kind == "slope":
            return np.degrees(np.arctan(np.hypot(east, south)))
        half = np.sqrt(0.5)
        lit = (half - half * (half * -south - half * east)) / np.sqrt(1 + east * east + south * south)
        return (np.clip(lit, 0, 1) * 255 + 0.5).astype(np.uint8)
    return best(work)


def fill():
    import numpy as np
    from rasterio.fill import fillnodata

    ground = noise(1201)
    rng = np.random.default_rng(9)
    known = np.ones(ground.shape, np.uint8)
    y, x = np.mgrid[:1201, :1201]
    while (known == 0).sum() < 131_000:
        row, col, radius = rng.uniform(0, 1201), rng.uniform(0, 1201), rng.uniform(5, 50)
        known[(y - row) ** 2 + (x - col) ** 2 < radius**2] = 0
    return best(lambda: fillnodata(ground.copy(), mask=known, max_search_distance=100, smoothing_iterations=3), 2)


NODES, EVERY, SYNTHESIS = "orograph-nodes", "every", "synthesis"
# What; our package, benchmark, function and argument; the peer's module and name; the peer.
ROWS = [
    ("blur, 1024²", (NODES, EVERY, "filter.gaussian_blur", "filter.gaussian_blur 1024"), "cv2", "OpenCV", blur),
    ("median of 3 × 3, 1024²", (NODES, EVERY, "filter.median", "filter.median 1024"), "cv2", "OpenCV", median),
    ("distance to a mask, 1024²", (NODES, EVERY, "mask.distance", "mask.distance 1024"), "scipy", "SciPy", distance),
    ("slope, 1024²", (NODES, EVERY, "measure.slope ", "measure.slope 1024"), "scipy", "SciPy", lambda: gradient("slope")),
    ("hillshade, 1024²", (NODES, EVERY, "look.hillshade", "look.hillshade 1024"), "scipy", "SciPy", lambda: gradient("shade")),
    ("cut, 80 × 27", (NODES, SYNTHESIS, "cut", "(80, 27)"), "maxflow", "PyMaxflow", lambda: maxflow_cut(80, 27)),
    ("cut, 1024 × 256", (NODES, SYNTHESIS, "cut", "(1024, 256)"), "maxflow", "PyMaxflow", lambda: maxflow_cut(1024, 256)),
    ("seam on a square, 511²", (NODES, SYNTHESIS, "seam_on_a_rectangle", "511"), "scipy", "SciPy", lambda: sine_poisson(511)),
    ("seam on a square, 2047²", (NODES, SYNTHESIS, "seam_on_a_rectangle", "2047"), "scipy", "SciPy", lambda: sine_poisson(2047)),
    ("seam on a disc, 512²", (NODES, SYNTHESIS, "seam_on_a_disc", "512"), "pyamg", "PyAMG", lambda: multigrid_disc(512)),
    ("seam on a disc, 512², and its box", (NODES, SYNTHESIS, "seam_on_a_disc", "512"), "scipy", "SciPy, sine transform", lambda: sine_poisson(512)),
    ("131,000 void cells patched, 1201²", (NODES, "repair", "patch_voids", "(1201, 131000)"), "rasterio", "GDAL, 3 smoothings", fill),
]


def main():
    asked = sys.argv[1:]
    print(f"{'what':36} {'ours':>10} {'peer':>10} {'ratio':>7}  peer")
    for what, bench, module, name, peer in ROWS:
        if asked and not any(word in what for word in asked):
            continue
        try:
            importlib.import_module(module)
        except ImportError:
            print(f"{what:36} left out: {module} is not installed")
            continue
        mine, theirs = ours(*bench), peer()
        print(f"{what:36} {mine * 1e3:7.2f} ms {theirs * 1e3:7.2f} ms {mine / theirs:7.2f}  {name}", flush=True)


if __name__ == "__main__":
    main()

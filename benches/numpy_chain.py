"""The ten operations of benches/chain.rs in NumPy, one array after the other, in single precision.

Prints the best of five runs in milliseconds. Needs NumPy alone: python3 benches/numpy_chain.py
"""

import time

import numpy as np

SIDE = 4096
CELL = np.float32(10_000 / SIDE)


def terrain(seed):
    """Smooth waves and a little noise, in the range of chain.rs's fractal noise."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0, 20, SIDE, dtype=np.float32)
    waves = 300 * np.sin(x + seed)[:, None] * np.cos(1.3 * x)[None, :]
    return waves + rng.standard_normal((SIDE, SIDE), dtype=np.float32)


def band(height, low, high, soft):
    """1 between the levels, falling smoothly to 0 over `soft` beyond them."""
    outside = np.maximum(low - height, height - high)
    t = np.clip(1 - outside / soft, 0, 1)
    return t * t * (3 - 2 * t)


def hillshade(height):
    """Horn's gradient lit from the north-west at 45 degrees, as grey RGBA."""
    z = np.pad(height, 1, mode="edge")
    nw, n, ne = z[:-2, :-2], z[:-2, 1:-1], z[:-2, 2:]
    w, e = z[1:-1, :-2], z[1:-1, 2:]
    sw, s, se = z[2:, :-2], z[2:, 1:-1], z[2:, 2:]
    east = ((ne + 2 * e + se) - (nw + 2 * w + sw)) / (8 * CELL)
    north = ((nw + 2 * n + ne) - (sw + 2 * s + se)) / (8 * CELL)
    half = np.float32(np.sqrt(0.5))
    lit = (half - half * (half * north - half * east)) / np.sqrt(1 + east * east + north * north)
    grey = (np.clip(lit, 0, 1) * 255 + 0.5).astype(np.uint8)
    picture = np.empty((*grey.shape, 4), np.uint8)
    picture[..., :3] = grey[..., None]
    picture[..., 3] = 255
    return picture


def chain(a, b, shift):
    f = np.float32
    raised = a + f(shift)
    total = raised + b
    remapped = (total + f(2000)) * f(0.75)
    clamped = np.clip(remapped, f(1000), f(2500))
    scaled = clamped * f(0.5)
    mixed = scaled + (b - scaled) * f(0.3)
    floored = np.maximum(mixed, f(300))
    mask = band(floored, f(450), f(700), f(100))
    masked = floored + (scaled - floored) * mask
    shaded = hillshade(masked)
    # The evaluator keeps every step's output; so does this.
    return raised, total, remapped, clamped, scaled, mixed, floored, mask, masked, shaded


def main():
    a, b = terrain(1), terrain(2)
    wall, cpu = [], []
    for sample in range(6):
        start = time.perf_counter(), time.process_time()
        kept = chain(a, b, sample)
        wall.append(time.perf_counter() - start[0])
        cpu.append(time.process_time() - start[1])
        del kept
    print(f"best of {len(wall)}: {1e3 * min(wall):.0f} ms wall, {1e3 * min(cpu):.0f} ms CPU")


main()

"""Terrain from 1,024 to 16,384 cells a side through graphs/large.ron: time and memory of whole processes.

Needs a release build of the program, Python alone, and about 4 GB of disk:

    cargo build --release
    python3 benches/scale/scale.py [--folder DIR] [--sides 1024,2048,…] [--plot docs/pictures/scale.svg]

For each side it makes hills of 10 m cells, runs the chain with the default memory, and at sides up to 4,096 again node by
node with memory to spare, whose files must be the same. Then a graph of twenty nodes at 8,192. Prints one table.
"""

import argparse
import filecmp
import os
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PROGRAM = ROOT / "target" / "release" / "orograph"


def run(graph, *options):
    """Seconds by the clock, seconds of CPU and peak MiB of one run."""
    begun = time.monotonic()
    command = [PROGRAM, "run", graph, "--cache", "none", "--quiet", *options]
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{graph} failed")
    return time.monotonic() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def plot(rows, path):
    """Microseconds a cell and peak memory over the side, as a picture of lines."""
    width, height, left, bottom, top = 640, 300, 56, 40, 24
    def x(i):
        return left + (width - left - 70) * i / max(len(rows) - 1, 1)
    def line(values, most, colour, label, side):
        def y(value):
            return bottom_y - (bottom_y - top) * value / most
        bottom_y = height - bottom
        points = " ".join(f"{x(i):.1f},{y(v):.1f}" for i, v in enumerate(values))
        marks = "".join(f'<circle cx="{x(i):.1f}" cy="{y(v):.1f}" r="3" fill="{colour}"/>' for i, v in enumerate(values))
        at, anchor = (left - 8, "end") if side == "left" else (width - 62, "start")
        ticks = "".join(
            f'<text x="{at}" y="{y(most * k / 4) + 4:.1f}" text-anchor="{anchor}" fill="{colour}">{most * k / 4:g}</text>'
            for k in range(5)
        )
        name = f'<text x="{at}" y="{top - 10}" text-anchor="{anchor}" fill="{colour}">{label}</text>'
        return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>{marks}{ticks}{name}'
    def nice(most):
        step = 10 ** (len(str(int(most * 1000))) - 1) / 1000
        return next(step * k for k in (1, 2, 4, 5, 8, 10) if step * k >= most)
    times = [row["cpu"] * 1e9 / row["side"] ** 2 for row in rows]
    memory = [row["peak"] for row in rows]
    sides = "".join(
        f'<text x="{x(i):.1f}" y="{height - bottom + 18}" text-anchor="middle">{row["side"]}²</text>' for i, row in enumerate(rows)
    )
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11">'
        f'<rect width="{width}" height="{height}" fill="white"/>'
        f'<line x1="{left}" y1="{height - bottom}" x2="{width - 70}" y2="{height - bottom}" stroke="#888"/>'
        f'{sides}{line(times, nice(max(times)), "#1f6fb4", "CPU, ns a cell", "left")}'
        f'{line(memory, nice(max(memory)), "#c2501e", "peak, MiB", "right")}</svg>\n'
    )


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--folder", type=pathlib.Path)
    options.add_argument("--sides", default="1024,2048,4096,8192,16384")
    options.add_argument("--memory", nargs="*", default=[], help="such as 1GiB; by default the program's own choice")
    options.add_argument("--plot", type=pathlib.Path)
    options = options.parse_args()
    if not PROGRAM.exists():
        sys.exit("build the program first: cargo build --release")
    memory = ["--memory", options.memory[0]] if options.memory else []
    rows = []
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        folder = pathlib.Path(folder)
        for side in map(int, options.sides.split(",")):
            size = [f"--set=hills.cells={side}", f"--set=hills.width={side * 10}", f"--set=hills.height={side * 10}"]
            made = run(HERE / "ground.ron", *size, "--out", folder, *memory)
            dem = f"--set=file={folder / 'ground.tif'}"
            wall, cpu, peak = run(ROOT / "graphs/large.ron", dem, "--out", folder / "a", *memory)
            rows.append({"side": side, "wall": wall, "cpu": cpu, "peak": peak})
            same = ""
            if side <= 4096:
                whole = run(ROOT / "graphs/large.ron", dem, "--out", folder / "b", "--memory", "16GiB")
                bands = run(ROOT / "graphs/large.ron", dem, "--out", folder / "a", "--memory", "32MiB")
                equal = filecmp.cmpfiles(folder / "a", folder / "b", ["large.tif", "large-shade.tif"], shallow=False)[0]
                same = f"in bands {bands[1]:.1f} s CPU, {bands[2]:.0f} MiB; node by node {whole[1]:.1f} s, {whole[2]:.0f} MiB; "
                same += "equal" if len(equal) == 2 else "DIFFERENT"
            cells = side**2
            print(
                f"{side:6}²  {wall:7.1f} s  {cpu:7.1f} s CPU  {cpu * 1e9 / cells:6.1f} ns a cell  {peak:6.0f} MiB"
                f"   ground {made[1] * 1e9 / cells:6.1f} ns a cell, {made[2]:5.0f} MiB   {same}",
                flush=True,
            )
            if side == 8192:
                for few in ([], ["--memory", "512MiB"]):
                    dem_of = f"--set=dem.file={folder / 'ground.tif'}"
                    wall, cpu, peak = run(HERE / "twenty.ron", dem_of, "--out", folder / "c", *few)
                    print(f"twenty nodes, {few[1] if few else 'default memory'}: {wall:.1f} s, {cpu:.1f} s CPU, {peak:.0f} MiB")
    if options.plot:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()

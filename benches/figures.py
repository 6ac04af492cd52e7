"""How long each figure of the gallery takes: one whole run of its graph, with nothing in the cache.

Needs a release build of the program, Python alone, and for some figures the folder of elevation models that OROGRAPH_DEM_DIR
names (by default ../shared/dem):

    cargo build --release
    python3 benches/figures.py [GRAPH…]

Runs what docs/gallery/figures.ron lists, or the graphs named, one after the other, with the settings of their pictures.
Prints one table, in Markdown, the dearest first. CPU is user and system time of all threads; it says more than the clock on
a machine that does other things.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target" / "release" / "orograph"
FIGURE = re.compile(r'graph: "([^"]+)",(?:\s*set: \{([^}]*(?:\$\{[^}]*\}[^}]*)*)\},)?')
SETTING = re.compile(r'"([^"]+)": "([^"]*)"')


def figures():
    """The graphs of the gallery in its order, with the settings of their pictures."""
    text = (ROOT / "docs/gallery/figures.ron").read_text()
    return {graph: SETTING.findall(settings or "") for graph, settings in FIGURE.findall(text)}


def run(graph, settings):
    """Seconds by the clock, seconds of CPU and peak MiB of one run."""
    with tempfile.TemporaryDirectory() as folder:
        command = [PROGRAM, "run", ROOT / "graphs" / f"{graph}.ron", "--cache", "none", "--quiet", "--out", folder]
        command += [f"--set={name}={value}" for name, value in settings]
        begun = time.monotonic()
        process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        if status:
            sys.exit(f"{graph} failed")
        return time.monotonic() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    if not PROGRAM.exists():
        sys.exit("build the program first: cargo build --release")
    known = figures()
    asked = sys.argv[1:] or list(known)
    if strange := [graph for graph in asked if graph not in known]:
        sys.exit(f"the gallery has no {', '.join(strange)}; docs/gallery/figures.ron lists its graphs")
    rows = [(graph, *run(graph, known[graph])) for graph in asked]
    print("| figure | CPU | wall | peak memory |\n|---|---|---|---|")
    for graph, wall, cpu, peak in sorted(rows, key=lambda row: -row[2]):
        print(f"| `{graph}` | {cpu:.2f} s | {wall:.2f} s | {peak:.0f} MiB |")
    print(f"| all {len(rows)} | {sum(row[2] for row in rows):.1f} s | {sum(row[1] for row in rows):.1f} s | |")


if __name__ == "__main__":
    main()

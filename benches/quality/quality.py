"""Every sketch on every exemplar: which bars of quality terrain meets, in one table.

Needs a release build of the program, Python alone, and the folder of real terrain that README.md names:

    cargo build --release
    OROGRAPH_DEM_DIR=… python3 benches/quality/quality.py [--seeds 0,1] [--cells 512,1000] [--set NAME=VALUE] [WORDS…]

WORDS choose pairs by parts of "sketch exemplar". A figure that misses its bar is marked with !; the last lines count them.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PROGRAM = ROOT / "target" / "release" / "orograph"
DEM = pathlib.Path(os.environ.get("OROGRAPH_DEM_DIR", ROOT.parent / "shared" / "dem"))
# What a stroke is, beside the paper that it is drawn on.
SKETCHES = {"half-life": "bright", "y": "bright", "s": "bright", "river": "dark", "water": "bright"}
EXEMPLARS = {
    "tatra_carpathians_3as_2401.tif": "ridge",
    "mount_jackson_n39w107_3as_1201.tif": "ridge",
    "big_tujunga_30m_1197x643.tif": "ridge",
    "southern_alps_s45e169_3as_1201.tif": "ridge",
    "grand_canyon_n36w113_1000.tif": "valley",
    "grand_canyon_west_512.tif": "valley",
}


def first(results, table, column):
    return results[table][column]["values"][0]


def row(results, metric, column):
    realism = results["realism"]
    value = realism[column]["values"][realism["metric"]["values"].index(metric)]
    return float("nan") if value is None else value


# Heading, the figure, and whether it is good enough.
FIGURES = [
    ("recall", lambda r: first(r, "adherence", "recall"), lambda v: v >= 0.95),
    ("chance", lambda r: first(r, "adherence", "recall_by_chance"), None),
    ("turned", lambda r: first(r, "adherence", "recall_turned"), None),
    ("stands", lambda r: first(r, "adherence", "standing_out"), None),
    ("run", lambda r: first(r, "adherence", "longest_run_least"), lambda v: v >= 0.8),
    ("pits", lambda r: row(r, "pit_density_ratio", "ratio"), lambda v: v <= 2),
    ("depth", lambda r: row(r, "pit_depth_ratio", "ratio"), lambda v: v <= 2),
    ("V_g", lambda r: row(r, "seam_step", "value"), lambda v: abs(v) <= 0.25),
    ("V_L", lambda r: row(r, "seam_bend", "value"), lambda v: abs(v) <= 0.25),
    ("slope", lambda r: row(r, "slope_w1", "ratio"), lambda v: v <= 1.5),
    ("prof", lambda r: row(r, "profile_curvature_w1", "ratio"), lambda v: v <= 1.5),
    ("plan", lambda r: row(r, "plan_curvature_w1", "ratio"), lambda v: v <= 1.5),
    ("beta", lambda r: row(r, "beta_difference", "ratio"), lambda v: v <= 1.5),
    ("forms", lambda r: row(r, "geomorphon_js", "ratio"), lambda v: v <= 1.5),
    ("Δbeta", lambda r: row(r, "beta_difference", "terrain") - row(r, "beta_difference", "exemplar"), None),
    ("halves", lambda r: row(r, "beta_difference", "halves"), None),
    ("slopes", lambda r: row(r, "slope_w1", "terrain") / row(r, "slope_w1", "exemplar"), None),
]


def run(sketch, exemplar, cells, seed, settings, out):
    kind = EXEMPLARS[exemplar]
    values = {
        "sketch": ROOT / "graphs" / "data" / "sketches" / f"{sketch}.png",
        "exemplar": DEM / exemplar,
        "kind": kind,
        "found": kind,
        "cells": cells,
        "strokes": SKETCHES[sketch],
    }
    command = [PROGRAM, "run", HERE / "pair.ron", "--json", "--quiet", "--seed", seed, "--out", out]
    for name, value in values.items():
        command += ["--set", f"{name}={value}"]
    for setting in settings:
        command += ["--set", setting]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)["results"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--cells", default="512,1000")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--out", help="keep pictures in this folder")
    asked = parser.parse_args()
    print(f"{'pair':46}" + "".join(f"{name:>8}" for name, _, _ in FIGURES), flush=True)
    table = []
    with tempfile.TemporaryDirectory() as scratch:
        for exemplar in EXEMPLARS:
            for sketch in SKETCHES:
                if not all(word in f"{sketch} {exemplar}" for word in asked.words):
                    continue
                for cells in asked.cells.split(","):
                    for seed in asked.seeds.split(","):
                        name = f"{sketch} {exemplar[:26]} {cells} {seed}"
                        out = pathlib.Path(asked.out or scratch) / name.replace(" ", "-")
                        results = run(sketch, exemplar, cells, seed, asked.settings, out)
                        values = [figure(results) for _, figure, _ in FIGURES]
                        table.append(values)
                        met = [bar is None or bar(value) for value, (_, _, bar) in zip(values, FIGURES)]
                        line = "".join(f"{v:7.3f}{' ' if ok else '!'}" for v, ok in zip(values, met))
                        print(f"{name:46}{line}", flush=True)
    columns = list(zip(*table))
    print(f"{'median':46}" + "".join(f"{statistics.median(column):7.3f} " for column in columns))
    misses = [0 if bar is None else sum(not bar(v) for v in column) for column, (_, _, bar) in zip(columns, FIGURES)]
    print(f"{'missed, of ' + str(len(table)):46}" + "".join(f"{n:7} " for n in misses))


if __name__ == "__main__":
    main()

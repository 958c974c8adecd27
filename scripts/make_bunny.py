#!/usr/bin/env python3
"""Makes data/models/bunny_200.obj, bunny_1k.obj and bunny_4k.obj.

In:  the Stanford bunny of the npm package `bunny` (closed, 1,839 vertices,
     3,674 faces), fetched with `npm pack`, or a copy of its index.js.
Out: the same bunny in 200, 1,000 and all faces, scaled evenly and moved into
     the box that the cameras of scenes 05 and 06 look at. Only `v` and `f`.

    pip install numpy==2.4.6 fast-simplification==0.2.0
    python3 scripts/make_bunny.py             # needs npm and the network
    python3 scripts/make_bunny.py index.js    # from a file already here

A mesh is written only if it is closed, wound outward and free of flat faces
and unused vertices; otherwise the script ends with a message and exit code 1.
"""

import json
import re
import subprocess
import sys
import tarfile
import tempfile
from collections import Counter
from pathlib import Path

import fast_simplification
import numpy as np

PACKAGE = "bunny@1.0.1"
MODELS = Path(__file__).resolve().parent.parent / "data" / "models"
BOX = np.array([[-0.19, 0.067, -0.12], [0.12, 0.375, 0.12]])

# The library's parameter "aggressiveness". 4 is the lowest whole number that
# still reaches 200 faces; higher ones make ears and head blunt.
EAGERNESS = 4

# OBJ coordinates are rounded to this many decimals before they are checked,
# so that what is checked is what a reader gets.
DECIMALS = 6


def read_package(index_js):
    """Reads vertices (n x 3) and zero-based faces (m x 3) of the package's index.js."""
    arrays = dict(re.findall(r"exports\.(\w+)\s*=\s*(\[\[.*?\]\])", index_js, re.S))
    vertices = np.array(json.loads(arrays["positions"]), dtype=np.float64)
    faces = np.array(json.loads(arrays["cells"]), dtype=np.int64)
    return vertices, faces


def fetch_package():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            ["npm", "pack", "--silent", PACKAGE], cwd=folder, check=True, stdout=subprocess.DEVNULL
        )
        archive = next(Path(folder).glob("*.tgz"))
        with tarfile.open(archive) as tar:
            return tar.extractfile("package/index.js").read().decode()


def place_in_box(vertices):
    """Scales evenly to the largest size that fits into the box, centred in x and z, with its feet
    on the bottom. The package's bunny already looks along -x with y up."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    scale = ((BOX[1] - BOX[0]) / (high - low)).min()
    shift = BOX.mean(axis=0) - scale * (low + high) / 2
    shift[1] = BOX[0, 1] - scale * low[1]
    return vertices * scale + shift


def faults(vertices, faces):
    """Returns what is wrong with a mesh, as a list of sentences."""
    found = []
    directed = Counter()
    for a, b, c in faces.tolist():
        directed.update([(a, b), (b, c), (c, a)])
    if max(directed.values()) > 1:
        found.append("an edge is used twice in one direction: winding or surface is broken")
    if any((b, a) not in directed for a, b in directed):
        found.append("the surface is not closed")
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1) / 2
    if area.min() < 1e-9:
        found.append(f"{(area < 1e-9).sum()} faces have no area")
    if np.einsum("ij,ij->", corners[:, 0], cross) <= 0:
        found.append("the winding points inward")
    if len(np.unique(faces)) != len(vertices):
        found.append("some vertices belong to no face")
    if len(np.unique(vertices, axis=0)) != len(vertices):
        found.append("two vertices share one place")
    return found


def write_obj(path, vertices, faces):
    lines = [
        f"# Stanford bunny, {len(faces)} faces, closed, wound outward.",
        "# Stanford 3D Scanning Repository, by way of the npm package `bunny`;",
        "# made by scripts/make_bunny.py.",
    ]
    lines += ["v " + " ".join(f"{x:.{DECIMALS}f}" for x in vertex) for vertex in vertices]
    lines += ["f {} {} {}".format(*(face + 1)) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def main():
    index_js = Path(sys.argv[1]).read_text() if len(sys.argv) > 1 else fetch_package()
    vertices, faces = read_package(index_js)
    vertices = place_in_box(vertices)
    for name, count in (("bunny_200", 200), ("bunny_1k", 1000), ("bunny_4k", len(faces))):
        v, f = vertices, faces
        if count < len(faces):
            v, f = fast_simplification.simplify(vertices, faces, target_count=count, agg=EAGERNESS)
        v = np.round(np.asarray(v, dtype=np.float64), DECIMALS)
        wrong = faults(v, f)
        if len(f) != count:
            wrong.append(f"{len(f)} faces instead of {count}")
        if wrong:
            sys.exit(f"{name}: " + "; ".join(wrong))
        write_obj(MODELS / f"{name}.obj", v, f)
        low, high = v.min(axis=0), v.max(axis=0)
        print(f"{name}.obj: {len(v)} vertices, {len(f)} faces, box {low} to {high}")


if __name__ == "__main__":
    main()

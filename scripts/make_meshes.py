#!/usr/bin/env python3
"""Makes bigger bunnies for measuring: bunny_64k.obj, bunny_1m.obj and bunny_4m.obj.

    scripts/make_meshes.py data/models/bunny_1k.obj FOLDER [--only 64k|1m|4m]

Every edge is halved 3, 5 or 6 times, so 1,000 triangles become 64,000, 1,024,000 or 4,096,000. The vertices then move
along their normals by a few octaves of sine waves, so that neighbours do not lie in one plane. The same input gives
the same files. Needs numpy (Debian: python3-numpy).
"""

import argparse
import sys
from pathlib import Path

try:
    import numpy as np
except ImportError:
    sys.exit("make_meshes.py needs numpy (Debian: apt-get install python3-numpy, then run /usr/bin/python3)")

HALVINGS = {"64k": 3, "1m": 5, "4m": 6}
OCTAVES = 5
# Amplitude and wavelength of the first octave, as parts of the diagonal of the mesh's box. Each further octave halves
# both.
HEIGHT, WAVE_LENGTH = 0.004, 0.15


def read_obj(path):
    vertices, faces = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            faces.append([int(w.split("/")[0]) - 1 for w in words[1:]])
    if not faces or any(len(f) != 3 or min(f) < 0 for f in faces):
        sys.exit(f"{path}: expected triangles with positive indices only")
    return np.array(vertices), np.array(faces)


def halve_edges(vertices, faces):
    """Splits each triangle into four at the midpoints of its edges; neighbours share a midpoint."""
    edges = np.sort(np.stack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).reshape(-1, 2), axis=1)
    keys, which = np.unique(edges[:, 0] * len(vertices) + edges[:, 1], return_inverse=True)
    midpoints = (vertices[keys // len(vertices)] + vertices[keys % len(vertices)]) / 2
    ab, bc, ca = (len(vertices) + which).reshape(3, -1)
    a, b, c = faces.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.vstack([vertices, midpoints]), np.vstack([np.column_stack(t) for t in corners])


def vertex_normals(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    sums = np.column_stack(
        [sum(np.bincount(faces[:, k], across[:, axis], len(vertices)) for k in range(3)) for axis in range(3)]
    )
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)


def displaced(vertices, faces):
    diagonal = np.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0))
    random = np.random.RandomState(1)  # its stream is fixed for all versions of numpy
    height = np.zeros(len(vertices))
    for octave in range(OCTAVES):
        for _ in range(3):
            direction = random.normal(size=3)
            direction *= 2**octave * 2 * np.pi / (WAVE_LENGTH * diagonal * np.linalg.norm(direction))
            height += HEIGHT * diagonal / 3 / 2**octave * np.sin(vertices @ direction + random.uniform(0, 2 * np.pi))
    return vertices + height[:, None] * vertex_normals(vertices, faces)


def write_obj(path, vertices, faces, block=100_000):
    with open(path, "w") as out:
        for kind, rows in (("v %.7f %.7f %.7f\n", vertices), ("f %d %d %d\n", faces + 1)):
            for at in range(0, len(rows), block):
                part = rows[at : at + block]
                out.write(kind * len(part) % tuple(part.ravel().tolist()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("mesh", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", choices=HALVINGS, action="append")
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    vertices, faces = read_obj(args.mesh)
    done = 0
    for name, halvings in HALVINGS.items():
        if args.only and name not in args.only:
            continue
        for _ in range(halvings - done):
            vertices, faces = halve_edges(vertices, faces)
        done = halvings
        path = args.folder / f"bunny_{name}.obj"
        write_obj(path, displaced(vertices, faces), faces)
        print(f"{path}: {len(vertices)} vertices, {len(faces)} triangles")


if __name__ == "__main__":
    main()

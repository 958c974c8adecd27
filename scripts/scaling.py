#!/usr/bin/env python3
"""Measures how the time of `a2` grows with the work: one table for each quantity, with slopes.

    scripts/scaling.py [--a2 target/release/a2] [--meshes FOLDER] [--repeats N] [--only WORD] [--threads 1,2,4]

The last table, "threads", has whole processes with 1, 2, 4 ... threads, up to as many as the processor has, in turn. Its
last column says what the machine can do: how much more so many processes of one thread do at the same time than one alone.

A slope is log(time ratio)/log(work ratio) between neighbouring rows: 1 means that twice the work takes twice the time,
0 that it costs nothing. Times are medians of whole processes. The time of the same job at 1 x 1 pixels is subtracted if
that job loads the same files. FOLDER holds bunny_64k.obj, bunny_1m.obj and bunny_4m.obj (scripts/make_meshes.py);
missing ones are left out.
"""

import argparse
import math
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

SCENE = """PerspectiveCamera {{ center 0 1 5 direction 0 -0.15 -1 up 0 1 0 angle 40 }}
Lights {{ numLights {lights} {light_blocks} }}
Background {{ color 0.2 0.3 0.5 ambientLight 0.1 0.1 0.1 }}
Materials {{ numMaterials 1 PhongMaterial {{ diffuseColor 0.7 0.6 0.5 specularColor 0.3 0.3 0.3 shininess 20 }} }}
Group {{ numObjects {objects} MaterialIndex 0 Plane {{ normal 0 1 0 offset -1 }} {object_blocks} }}
"""


def scene(path, lights=1, spheres=1, mesh=None):
    """Makes a scene of a plane with spheres in a cube, or with a mesh, under directional lights."""
    light = "DirectionalLight {{ direction {} -1 -0.5 color 0.3 0.3 0.3 }}"
    light_blocks = " ".join(light.format(i / lights - 0.5) for i in range(lights))
    if mesh:
        blocks = [f"Transform {{ Translate 0 -1 0 UniformScale 10 TriangleMesh {{ obj_file {mesh} }} }}"]
    else:
        side = round(spheres ** (1 / 3)) or 1
        places = ((i % side, i // side % side, i // side**2) for i in range(spheres))
        step = 2 / side
        blocks = [
            f"Sphere {{ center {-1 + (x + 0.5) * step:.5f} {-0.9 + (y + 0.5) * step:.5f} {-1 + (z + 0.5) * step:.5f}"
            f" radius {0.3 * step:.5f} }}"
            for x, y, z in places
        ]
    path.write_text(
        SCENE.format(lights=lights, light_blocks=light_blocks, objects=1 + len(blocks), object_blocks="\n".join(blocks))
    )
    return path


def seconds(command, repeats):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        subprocess.run([str(word) for word in command], check=True)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def seconds_side_by_side(command, count):
    start = time.perf_counter()
    processes = [subprocess.Popen([str(word) for word in command]) for _ in range(count)]
    if any(process.wait() for process in processes):
        raise subprocess.SubprocessError(command)
    return time.perf_counter() - start


def thread_table(args, folder):
    """Prints how many times as fast whole processes are with more threads; `args.threads` begins with 1."""
    large = ["-input", ROOT / "data/scene01_plane.txt", "-size", 4000, 4000]
    three = [*large, "-normals", folder / "n.png", "-depth", 8, 18, folder / "d.png"]
    many_rays = ["-input", ROOT / "data/scene06_bunny_1k.txt", "-size", 400, 400, "-jitter", "-filter"]
    jobs = {
        "scene01, 4,000 x 4,000": large,
        "scene01, 4,000 x 4,000, three pictures": three,
        "scene06, 400 x 400, 144 rays a pixel": [*many_rays, "-bounces", 4, "-shadows"],
    }
    mesh = args.meshes and (args.meshes / "bunny_1m.obj").resolve()
    if mesh and mesh.exists():
        file = scene(folder / "mesh.txt", mesh=mesh)
        jobs["1,024,000 triangles, 1 x 1 pixels: reading and building"] = ["-input", file, "-size", 1, 1]
    most = args.threads[-1]
    print(f"\n| threads | {' | '.join(f'{n}' for n in args.threads)} | {most} processes |")
    print(f"|---|{'---|' * (len(args.threads) + 1)}")
    for name, job in jobs.items():
        base = [args.a2, "-quiet", "-output", folder / "o.png", *job, "-threads"]
        rounds = [
            [*(seconds([*base, n], 1) for n in args.threads), seconds_side_by_side([*base, 1], most)]
            for _ in range(args.repeats)
        ]
        *times, together = (statistics.median(column) for column in zip(*rounds))
        cells = [f"{times[0] / time:.2f} ({time:.3f} s)" for time in times]
        print(f"| {name} | {' | '.join(cells)} | {most * times[0] / together:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--a2", type=Path, default=ROOT / "target" / "release" / "a2")
    parser.add_argument("--meshes", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--only", default="")
    cores = len(os.sched_getaffinity(0))
    powers = ",".join(str(2**n) for n in range(cores.bit_length()))
    parser.add_argument("--threads", type=lambda text: [int(n) for n in text.split(",")], default=powers)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        file = folder / "s.txt"

        def job(size=400, threads=2, bounces=0, flags=(), **what):
            scene(file, **what)
            base = [args.a2, "-quiet", "-input", file, "-output", folder / "o.png", "-threads", threads]
            base += ["-shadows", "-bounces", bounces, *flags, "-size"]
            loading = seconds([*base, 1, 1], args.repeats)
            return max(seconds([*base, size, size], args.repeats) - loading, 1e-6), loading

        meshes = {200: ROOT / "data/models/bunny_200.obj", 1000: ROOT / "data/models/bunny_1k.obj"}
        if args.meshes:
            big = {64_000: "64k", 1_024_000: "1m", 4_096_000: "4m"}
            meshes |= {count: (args.meshes / f"bunny_{name}.obj").resolve() for count, name in big.items()}
        sampling = {1: (), 9: ("-filter",), 16: ("-jitter",), 144: ("-jitter", "-filter")}
        tables = {
            "triangles": [(n, {"mesh": path}) for n, path in meshes.items() if path.exists()],
            "pixels": [(side * side, {"size": side}) for side in (200, 400, 800, 1600)],
            "rays a pixel": [(n, {"flags": flags, "size": 200}) for n, flags in sampling.items()],
            "lights": [(n, {"lights": n}) for n in (1, 4, 16, 64)],
            "bounces": [(n, {"bounces": n, "spheres": 27}) for n in (1, 2, 4, 8)],
            "objects": [(n, {"spheres": n}) for n in (1, 27, 1000, 27_000, 1_000_000)],
        }
        for name, rows in tables.items():
            if args.only not in name:
                continue
            print(f"\n| {name} | rendering, s | slope | the rest, s |\n|---|---|---|---|")
            before = None
            for work, what in rows:
                rendering, loading = job(**what)
                slope = ""
                if before:
                    slope = f"{math.log(rendering / before[1]) / math.log(work / before[0]):.2f}"
                print(f"| {work:,} | {rendering:.3f} | {slope} | {loading:.3f} |", flush=True)
                before = (work, rendering)
        if args.only in "threads":
            thread_table(args, folder)


if __name__ == "__main__":
    main()

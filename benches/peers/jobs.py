"""The jobs that are measured: whole processes, as the command lines that do the same work in a2 and in its peers.

In: the paths of a2, of the scenes and of a working folder, and the picture size. Out: a list of `Job`. Scenes are
translated and meshes are made here, before anything is timed.
"""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from translate import translate

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "scripts"))
import batch  # noqa: E402

# scene01: its line of the course's batch.
COURSE = {scene.short_name: scene for scene in batch.read()}

TRIANGLES = {"64k": "64,000", "1m": "1,024,000"}


@dataclass
class Job:
    name: str
    # For each program the command lines that it runs one after another. The others are compared with the first
    # program.
    programs: dict = field(default_factory=dict)
    # Pictures that must exist in the end: path and width.
    pictures: list = field(default_factory=list)
    is_long: bool = False


def make_mesh(name, base_mesh, folder):
    """Makes FOLDER/bunny_NAME.obj by make_meshes.py, with any Python that has numpy; or returns None."""
    maker = ROOT / "scripts" / "make_meshes.py"
    for python in (sys.executable, "/usr/bin/python3"):
        command = [python, maker, base_mesh, folder, "--only", name]
        if Path(python).exists() and subprocess.run(command, capture_output=True).returncode == 0:
            return folder / f"bunny_{name}.obj"
    return None


class Planner:
    def __init__(self, ours, peers, data, work, size, threads):
        self.ours, self.peers, self.data, self.work = ours, peers, data, work
        self.size, self.threads = size, threads
        work.mkdir(parents=True, exist_ok=True)

    def scene(self, prefix):
        found = sorted(self.data.glob(f"{prefix}*.txt"))
        if len(found) != 1:
            raise FileNotFoundError(f"expected one {prefix}*.txt in {self.data}, found {len(found)}")
        return found[0]

    def picture(self, job, name, scale=1):
        path = self.work / name
        job.pictures.append((path, self.size * scale))
        return str(path)

    def a2(self, binary, scene, output, options, threads=None):
        size = str(self.size)
        command = [binary, "-input", str(scene), "-output", output, "-size", size, size]
        return [*command, "-threads", str(threads or self.threads), "-quiet", *options]

    def one_picture(self, name, scene, options, samples=1):
        """Makes a job: one colour picture of `scene` by a2 and every peer."""
        stem = scene.stem
        bounces = int(options[options.index("-bounces") + 1]) if "-bounces" in options else 0
        translate(scene, self.work, (self.size, self.size), bounces, "-shadows" in options, tuple(self.peers))
        job = Job(name, is_long=samples > 1)
        sampling = ["-jitter", "-filter"] if samples > 1 else []
        for label, binary in self.ours.items():
            output = self.picture(job, f"{label.replace('/', '_')}_{stem}.png")
            job.programs[label] = [self.a2(binary, scene, output, [*options, *sampling])]
        size, threads = str(self.size), str(self.threads)
        if "tachyon" in self.peers:
            output = self.picture(job, f"tachyon_{stem}.png")
            command = ["tachyon", f"{stem}.dat", "-res", size, size, "-numthreads", threads, "-shade_phong"]
            # Tachyon shoots one ray and then this many more.
            command += ["-aasamples", "143"] if samples > 1 else []
            job.programs["Tachyon"] = [[*command, "-format", "PNG", "-o", output]]
        if "povray" in self.peers:
            # POV-Ray takes at most 9 x 9 samples a pixel, so it renders like a2: 3 x 3 the pixels, 4 x 4 jittered
            # samples in each.
            scale = 3 if samples > 1 else 1
            output = self.picture(job, f"povray_{stem}.png", scale)
            command = ["povray", f"+I{stem}.pov", f"+O{output}", f"+W{self.size * scale}", f"+H{self.size * scale}"]
            command += ["+AM1", "+A0.0", "+R4", "+J"] if samples > 1 else ["-A"]
            job.programs["POV-Ray"] = [[*command, f"+WT{threads}", "-D", "-GA", "+FN8", "File_Gamma=1.0"]]
        return job

    def big_mesh(self, job_name, mesh_name):
        """Makes a scene06 with a bigger bunny instead of its own; or returns None, with a message."""
        if not make_mesh(mesh_name, self.data / "models" / "bunny_1k.obj", self.work):
            print(f"{job_name}: left out, make_meshes.py failed (it needs numpy)", file=sys.stderr)
            return None
        original = self.scene("scene06")
        text = re.sub(r"obj_file\s+\S+", f"obj_file bunny_{mesh_name}.obj", original.read_text())
        cube_map = lambda m: f"cubeMap {os.path.relpath(original.parent / m[1], self.work)}"
        scene = self.work / f"big_{mesh_name}.txt"
        scene.write_text(re.sub(r"cubeMap\s+(\S+)", cube_map, text))
        return self.one_picture(job_name, scene, COURSE["scene06"].flags)

    def batch(self, job_name):
        job = Job(job_name)
        for label, binary in self.ours.items():
            job.programs[label] = []
            for prefix, scene in COURSE.items():
                out = [self.picture(job, f"{label.replace('/', '_')}_{name}") for name in scene.pictures]
                planes = ["-normals", out[1], "-depth", *scene.depth, out[2]]
                job.programs[label].append(self.a2(binary, self.scene(prefix), out[0], [*scene.flags, *planes]))
        return job

    def two_threads(self, job_name):
        job = Job(job_name, is_long=True)
        scene, options = self.scene("scene06"), [*COURSE["scene06"].flags, "-jitter", "-filter"]
        for label, binary in self.ours.items():
            for threads, name in ((2, label), (1, f"{label}, 1 thread")):
                output = self.picture(job, f"{label.replace('/', '_')}_threads{threads}.png")
                job.programs[name] = [self.a2(binary, scene, output, options, threads)]
        return job

    def jobs(self, big, wanted):
        """Returns the jobs whose name contains `wanted`. Only these are prepared."""
        plans = []
        for samples in (1, 144):
            for p in ("scene01", "scene06", "scene07") if samples == 1 else ("scene06", "scene07"):
                name = p if samples == 1 else f"{p}, 144 rays a pixel"
                plans.append((name, lambda n=name, p=p, s=samples: self.one_picture(n, self.scene(p), COURSE[p].flags, s)))
        name = f"scene06, {TRIANGLES[big]} triangles"
        plans.append((name, lambda n=name: self.big_mesh(n, big)))
        plans.append(("the 21 pictures", lambda: self.batch("the 21 pictures")))
        name = "scene06, 144 rays a pixel, 2 threads against 1"
        plans.append((name, lambda n=name: self.two_threads(n)))
        for name, plan in plans:
            if wanted in name and (job := plan()):
                yield job

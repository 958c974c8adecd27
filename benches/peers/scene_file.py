"""Reads an a2 scene into flat, world-space data for the writers of other ray tracers.

In: the path of a scene file. Out: a `Scene` whose objects are spheres, planes and triangle meshes with their
transforms multiplied. The scene must be valid: mistakes are only reported by a2 itself.
"""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return scale(a, 1.0 / length) if length > 0.0 else a


def product(a, b):
    return tuple(tuple(sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)) for r in range(4))


def point_by(m, p):
    return tuple(m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3] for r in range(3))


def normal_matrix(m):
    """Returns the cofactors of the upper 3 x 3: the inverse transpose, up to a positive or negative factor."""
    rows = [m[r][:3] for r in range(3)]
    cofactors = (cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]))
    sign = 1.0 if dot(rows[0], cofactors[0]) > 0.0 else -1.0
    return tuple(scale(row, sign) for row in cofactors)


def normal_by(n, v):
    return unit((dot(n[0], v), dot(n[1], v), dot(n[2], v)))


@dataclass
class Mesh:
    vertices: list
    normals: list
    faces: list

    def world_from(self, m):
        if m == IDENTITY:
            return self
        n = normal_matrix(m)
        return Mesh([point_by(m, v) for v in self.vertices], [normal_by(n, v) for v in self.normals], self.faces)


@dataclass
class Scene:
    camera: dict = field(default_factory=dict)
    lights: list = field(default_factory=list)
    background: dict = field(default_factory=dict)
    materials: list = field(default_factory=list)
    objects: list = field(default_factory=list)  # (kind, material index, world_from_object, content)


def load_obj(path):
    """Reads positions and triangles of an OBJ, and computes a2's vertex normals: sums of the unit face normals."""
    vertices, faces = [], []
    with open(path) as lines:
        for line in lines:
            if line.startswith("v "):
                x, y, z = line.split()[1:4]
                vertices.append((float(x), float(y), float(z)))
            elif line.startswith("f "):
                corner = [int(c.split("/", 1)[0]) for c in line.split()[1:]]
                corner = [c - 1 if c > 0 else len(vertices) + c for c in corner]
                faces.extend((corner[0], corner[k], corner[k + 1]) for k in range(1, len(corner) - 1))
    sums = [(0.0, 0.0, 0.0)] * len(vertices)
    for i, j, k in faces:
        n = unit(cross(sub(vertices[j], vertices[i]), sub(vertices[k], vertices[i])))
        sums[i], sums[j], sums[k] = add(sums[i], n), add(sums[j], n), add(sums[k], n)
    return Mesh(vertices, [unit(s) for s in sums], faces)


class Reader:
    def __init__(self, path):
        self.folder = Path(path).parent
        # A comment begins only where a token could begin, so that a path may contain `#` and `//`.
        text = re.sub(r"(?<![^\s{}])(#|//).*", "", Path(path).read_text())
        self.tokens = text.replace("{", " { ").replace("}", " } ").split()
        self.at = 0
        self.scene = Scene()
        self.material = None
        self.meshes = {}

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def expect(self, token):
        found = self.next()
        if found != token:
            raise ValueError(f"expected {token!r}, found {found!r} (token {self.at})")

    def numbers(self, n):
        return tuple(float(self.next()) for _ in range(n))

    def fields(self, sizes):
        """Parses `{ name values ... }` with `sizes[name]` numbers for each name; 0 means one word."""
        self.expect("{")
        found = {}
        while (name := self.next()) != "}":
            values = self.numbers(sizes[name]) if sizes[name] else self.next()
            found[name] = values[0] if sizes[name] == 1 else values
        return found

    def read(self):
        while self.at < len(self.tokens):
            block = self.next()
            if block == "PerspectiveCamera":
                self.scene.camera = self.fields({"center": 3, "direction": 3, "up": 3, "angle": 1})
            elif block == "Background":
                self.scene.background = self.fields({"color": 3, "ambientLight": 3, "cubeMap": 0})
            elif block == "Lights":
                sizes = {"direction": 3, "position": 3, "color": 3, "falloff": 1}
                self.scene.lights = self.counted("numLights", sizes)
            elif block == "Materials":
                sizes = {"diffuseColor": 3, "specularColor": 3, "shininess": 1, "bump": 0}
                self.scene.materials = [m for _, m in self.counted("numMaterials", sizes)]
            elif block == "Group":
                self.group(IDENTITY)
            else:
                raise ValueError(f"unknown block {block!r}")
        if not self.scene.lights:
            self.scene.background["ambientLight"] = (1.0, 1.0, 1.0)
        return self.scene

    def counted(self, count_name, sizes):
        self.expect("{")
        self.expect(count_name)
        items = [(self.next(), self.fields(sizes)) for _ in range(int(self.next()))]
        self.expect("}")
        return items

    def group(self, m):
        self.expect("{")
        self.expect("numObjects")
        self.next()
        while (kind := self.next()) != "}":
            if kind == "MaterialIndex":
                self.material = int(self.next())
            else:
                self.object(kind, m)

    def object(self, kind, m):
        if kind == "Group":
            return self.group(m)
        if kind == "Transform":
            return self.transform(m)
        sizes = {
            "Sphere": {"center": 3, "radius": 1},
            "Plane": {"normal": 3, "offset": 1},
            "Triangle": {"vertex0": 3, "vertex1": 3, "vertex2": 3},
            "TriangleMesh": {"obj_file": 0},
        }[kind]
        content = self.fields(sizes)
        if kind == "Triangle":
            v = [content["vertex0"], content["vertex1"], content["vertex2"]]
            n = unit(cross(sub(v[1], v[0]), sub(v[2], v[0])))
            kind, content = "TriangleMesh", Mesh(v, [n, n, n], [(0, 1, 2)])
        elif kind == "TriangleMesh":
            path = self.folder / content["obj_file"]
            if path not in self.meshes:
                self.meshes[path] = load_obj(path)
            content = self.meshes[path]
        self.scene.objects.append((kind, self.material, m, content))

    def transform(self, m):
        self.expect("{")
        while (name := self.next()) not in ("Sphere", "Plane", "Triangle", "TriangleMesh", "Group", "Transform"):
            if name == "Matrix4f":
                columns = [self.numbers(4) for _ in range(4)]
                m = product(tuple(zip(*columns)), m)
            else:
                m = product(m, self.transformation(name))
        self.object(name, m)
        self.expect("}")

    def transformation(self, name):
        if name == "Translate":
            x, y, z = self.numbers(3)
            return ((1, 0, 0, x), (0, 1, 0, y), (0, 0, 1, z), (0, 0, 0, 1))
        if name in ("Scale", "UniformScale"):
            x, y, z = self.numbers(3) if name == "Scale" else self.numbers(1) * 3
            return ((x, 0, 0, 0), (0, y, 0, 0), (0, 0, z, 0), (0, 0, 0, 1))
        if name == "Rotate":
            self.expect("{")
            *axis, degrees = self.numbers(4)
            self.expect("}")
        else:
            axis = {"XRotate": (1, 0, 0), "YRotate": (0, 1, 0), "ZRotate": (0, 0, 1)}[name]
            (degrees,) = self.numbers(1)
        return rotation(unit(axis), math.radians(degrees))


def rotation(a, angle):
    """Makes a right-handed rotation about the unit axis `a` (Rodrigues)."""
    s, c = math.sin(angle), math.cos(angle)
    across = ((0, -a[2], a[1]), (a[2], 0, -a[0]), (-a[1], a[0], 0))
    rows = [
        tuple((c if r == k else 0.0) + (1 - c) * a[r] * a[k] + s * across[r][k] for k in range(3)) + (0.0,)
        for r in range(3)
    ]
    return (*rows, (0.0, 0.0, 0.0, 1.0))


def read_scene(path):
    return Reader(path).read()

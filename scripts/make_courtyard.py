#!/usr/bin/env python3
"""Makes the meshes of data/courtyard.txt, data/models/courtyard/*.obj.

In:  nothing; all measures are constants below, in metres, y up, paving at y = 0.
Out: one file per material and part. The four sides of the court are equal, so
     only the side at negative z is made; the scene rotates it about y.

Walls are single sheets that face the court, because no ray of the cube map sees
their backs. Vertices are shared only where the surface is smooth or flat, because
normals are averaged over all faces that share a vertex.

    python3 scripts/make_courtyard.py         # needs Python alone

scripts/make_courtyard.sh runs this and renders the cube map.
"""

from math import cos, pi, sin
from pathlib import Path

MODELS = Path(__file__).resolve().parent.parent / "data" / "models" / "courtyard"

BAY = 2.5
BAYS = 9
HALF = BAY * BAYS / 2  # from the middle of the court to the arcade
WALL = 0.5  # thickness of the arcade
STEP = 0.15  # gallery floor above the paving
GALLERY = 3.4  # from the arcade's face to the gallery's back wall
SPRING = 3.0  # where the arches of the ground floor begin
ARCH = 0.98  # their inner radius
FLOOR2 = 4.75  # string course between the storeys
PARAPET = 5.75
SPRING2 = 6.95
ARCH2 = 0.45
EAVES = 8.1


class Mesh:
    """Convex polygons with outward winding. `flat` faces share vertices only with faces in
    the same plane, `smooth` ones with their own surface."""

    def __init__(self):
        self.vertices = {}
        self.faces = []
        self.surfaces = 0

    def _corner(self, point, surface):
        key = (tuple(round(x, 3) + 0.0 for x in point), surface)
        return self.vertices.setdefault(key, len(self.vertices))

    def _face(self, corners):
        """Adds a face. Equal corners, as at the tip of a body of revolution, count once."""
        corners = list(dict.fromkeys(corners))
        if len(corners) > 2:
            self.faces.append(corners)

    def flat(self, *points):
        """Adds a convex polygon, its corners counter-clockwise seen from outside."""
        p, q, r = points[:3]
        u = [b - a for a, b in zip(p, q)]
        w = [b - a for a, b in zip(p, r)]
        n = (u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0])
        length = sum(x * x for x in n) ** 0.5
        normal = tuple(round(x / length, 2) + 0.0 for x in n)
        self._face(self._corner(point, normal) for point in points)

    def smooth(self, rows):
        """Adds a grid of points. Seen from outside, rows go from left to right, and each row is
        above the row before."""
        self.surfaces += 1
        grid = [[self._corner(point, self.surfaces) for point in row] for row in rows]
        for low, high in zip(grid, grid[1:]):
            for k in range(len(low) - 1):
                self._face((low[k], low[k + 1], high[k + 1], high[k]))

    def box(self, low, high, without=""):
        """Adds a box. `without` names sides to leave out, of l r d u b f: -x +x -y +y -z +z."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        sides = {
            "l": ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
            "r": ((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
            "d": ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
            "u": ((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
            "b": ((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
            "f": ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        }
        for name, corners in sides.items():
            if name not in without:
                self.flat(*corners)

    def turned(self, centre, runs, around):
        """Adds a body of revolution about the vertical through `centre`. Each run is a smooth profile
        of (radius, height) pairs from bottom to top; between two runs there is a crease."""
        cx, cy, cz = centre
        turns = [2 * pi * k / around for k in range(around + 1)]
        for run in runs:
            self.smooth([[(cx + r * sin(a), cy + y, cz + r * cos(a)) for a in turns] for r, y in run])

    def add(self, other, quarters):
        """Adds the flat faces of another mesh, rotated about y by a number of quarter turns."""
        points = [point for point, _ in other.vertices]
        for face in other.faces:
            turned = [points[i] for i in face]
            for _ in range(quarters):
                turned = [(z, y, -x) for x, y, z in turned]
            self.flat(*turned)

    def write(self, name):
        lines = [f"# {name} of the courtyard, made by scripts/make_courtyard.py"]
        lines += ["v " + " ".join(f"{x:g}" for x in point) for point, _ in self.vertices]
        lines += ["f " + " ".join(str(i + 1) for i in face) for face in self.faces]
        path = MODELS / f"{name}.obj"
        path.write_text("\n".join(lines) + "\n")
        print(f"{path.name}: {len(self.vertices)} vertices, {len(self.faces)} faces")


def arch(wall, stones, middle, half, spring, radius, ring, top, z):
    """One bay of an arcade: the wall over a round arch, from `spring` to `top`, and its ring of
    wedge stones, which the two meshes in `stones` take in turn."""
    count = 13 if radius > 0.6 else 7

    def at(r, k, depth=z):
        angle = pi * k / count
        return (middle + r * cos(angle), spring + r * sin(angle), depth)

    outer, back = radius + ring, z - WALL
    for k in range(count):
        stone = stones[k % 2]
        stone.flat(at(radius, k), at(outer, k), at(outer, k + 1), at(radius, k + 1))
        stone.flat(at(radius, k, back), at(radius, k), at(radius, k + 1), at(radius, k + 1, back))
        right, left = at(outer, k), at(outer, k + 1)
        wall.flat(left, right, (right[0], top, z), (left[0], top, z))
    for side in (-1, 1):
        xs = sorted((middle + side * outer, middle + side * half))
        wall.flat((xs[0], spring, z), (xs[1], spring, z), (xs[1], top, z), (xs[0], top, z))


def column(stone, x, z, foot, head, radius, around):
    """A column with base and capital, `head` being the top of its cover stone. Slender ones go
    without the plinth and the moulded base, which cannot be seen from ten metres."""
    wide = radius * 1.5
    slender = radius < 0.1
    cap, tall = head - foot - radius * 2.2, head - foot
    runs = [
        [(radius * 1.05, 0 if slender else radius * 1.6), (radius * 0.88, cap)],
        [(radius * 0.9, cap), (radius * 1.05, cap + radius * 0.9), (wide, tall - radius * 0.5)],
    ]
    if not slender:
        stone.box((x - wide, foot, z - wide), (x + wide, foot + radius * 0.7, z + wide), "db")
        runs.insert(0, [(wide, radius * 0.7), (wide * 0.98, radius * 1.2), (radius * 1.1, radius * 1.6)])
        runs.append([(radius * 1.1, cap - radius * 0.3), (radius * 1.1, cap)])
    stone.turned((x, foot, z), runs, around)
    stone.box((x - wide, head - radius * 0.5, z - wide), (x + wide, head, z + wide), "bu")


def ledge(stone, y0, y1, out, length, z):
    """A moulding along a side, in two steps. It runs into its neighbours at the corners."""
    middle = (y0 + y1) / 2
    stone.box((-length, y0, z - 0.1), (length, middle, z + out / 2), "lrbu")
    stone.box((-length, middle, z - 0.1), (length, y1, z + out), "lrb")


def bay_middles(every=1, first=0):
    return [-HALF + BAY * (k + 0.5) for k in range(first, BAYS, every)]


def side():
    """The arcade and the loggia above it, at negative z, facing +z."""
    stone, brick, plaster, tiles = Mesh(), Mesh(), Mesh(), Mesh()
    z = -HALF
    for middle in bay_middles():
        arch(plaster, (brick, stone), middle, BAY / 2, SPRING, ARCH, 0.265, FLOOR2, z)
        for part in (-1, 1):
            arch(plaster, (brick, stone), middle + part * BAY / 4, BAY / 4, SPRING2, ARCH2, 0.165, EAVES, z)
        low, high = FLOOR2 + 0.33, PARAPET - 0.23
        tiles.box((middle - 1.05, low, z), (middle + 1.05, high, z + 0.03), "b")
    for k in range(1, BAYS):
        x = -HALF + BAY * k
        column(stone, x, z - WALL / 2, STEP, SPRING, 0.18, 10)
        tiles.flat(*(disc(x, 4.2, z + 0.02, 0.24, 12)))
    for k in range(1, 2 * BAYS):
        column(stone, -HALF + BAY / 2 * k, z - WALL / 2, PARAPET, SPRING2, 0.085, 6)
    for foot, head in ((STEP, SPRING), (PARAPET, SPRING2)):
        stone.box((-HALF - WALL, foot, z - WALL), (-HALF + 0.27, head, z), "d")
    plaster.box((-HALF, FLOOR2, z - WALL), (HALF, PARAPET - 0.12, z), "lrdu")
    ledge(stone, FLOOR2 - 0.1, FLOOR2 + 0.15, 0.16, HALF, z)
    stone.box((-HALF, PARAPET - 0.12, z - WALL), (HALF, PARAPET, z + 0.06), "lr")
    ledge(stone, EAVES - 0.3, EAVES, 0.3, HALF, z)
    stone.box((-HALF, 0, z - WALL - 0.2), (HALF, STEP, z + 0.45), "lrdb")
    stone.write("side_stone")
    brick.write("side_brick")
    plaster.write("side_plaster")
    tiles.write("side_tiles")


def disc(x, y, z, radius, corners, turn=2 * pi):
    """Points of a disc, or of the upper part of one, that faces +z."""
    steps = corners if turn == 2 * pi else corners + 1
    return [(x + radius * cos(turn * k / corners), y + radius * sin(turn * k / corners), z) for k in range(steps)]


def gallery():
    """The rooms behind the arches: back walls, tiled dado, doors, windows, lamps, ceilings."""
    wall, tiles, wood, stone, lamps, shutters = (Mesh() for _ in range(6))
    back, front = -HALF - GALLERY, -HALF
    far, upper = HALF + GALLERY, back + 1
    wall.flat((-far, STEP, back), (far, STEP, back), (far, FLOOR2, back), (-far, FLOOR2, back))
    wall.flat((-far, FLOOR2, upper), (far, FLOOR2, upper), (far, EAVES, upper), (-far, EAVES, upper))
    stone.flat((-far, STEP, front), (far, STEP, front), (far, STEP, back), (-far, STEP, back))
    tiles.box((-far, STEP, back - 1), (far, 1.45, back + 0.04), "lrdb")
    for x in bay_middles(2):
        z = back + 0.08
        wood.flat((x - 0.7, STEP, z), (x + 0.7, STEP, z), (x + 0.7, 2.6, z), (x - 0.7, 2.6, z))
        wood.flat(*disc(x, 2.6, z, 0.7, 12, pi))
        unseen = Mesh()  # the wall is there already, only the ring of stones is wanted
        arch(unseen, (stone, stone), x, 0.95, 2.6, 0.7, 0.22, 3.6, z)
        for edge in (-1, 1):
            xs = sorted((x + edge * 0.7, x + edge * 0.92))
            stone.box((xs[0], STEP, z - 0.1), (xs[1], 2.6, z + 0.05), "db")
    for x in bay_middles(2, 1):
        stone.box((x - 0.62, 1.6, back), (x + 0.62, 3.3, back + 0.05), "b")
        wood.box((x - 0.02, 1.72, back), (x + 0.02, 3.18, back + 0.08), "b")
        shutters.box((x - 0.5, 1.72, back), (x + 0.5, 3.18, back + 0.07), "b")
    for k in range(2 * BAYS + 1):
        x = -HALF + BAY / 2 * k
        wood.box((x - 0.08, FLOOR2 - 0.45, back), (x + 0.08, FLOOR2 - 0.2, front - WALL), "ub")
    for y, depth in ((FLOOR2 - 0.2, back), (EAVES - 0.2, upper)):
        wood.flat((-far, y, depth), (far, y, depth), (far, y, front), (-far, y, front))
    for x in bay_middles():
        wood.box((x - 0.95, FLOOR2, upper - 1), (x - 0.3, 7.2, upper + 0.06), "db")
        z, chain = front - WALL / 2, 0.012
        glass = [[(0.0, -0.2), (0.13, -0.05), (0.16, 0.12)], [(0.16, 0.12), (0.0, 0.26)]]
        lamps.turned((x, 3.35, z), glass, 8)
        wood.box((x - chain, 3.6, z - chain), (x + chain, SPRING + ARCH + 0.02, z + chain), "du")
    wall.write("gallery_wall")
    tiles.write("gallery_tiles")
    wood.write("gallery_wood")
    stone.write("gallery_stone")
    lamps.write("gallery_lamps")
    shutters.write("gallery_shutters")


def roof():
    """Rows of half-round tiles from the eaves outward and up, cut off along the valleys in which
    neighbouring roofs meet."""
    tiles = Mesh()
    eaves, ridge, pitch = HALF - 0.5, HALF + 4.0, 0.95
    per_row, row = 5, 0.75
    count = int(2 * ridge / row) * per_row
    low, high, lip = [], [], []
    for k in range(count + 1):
        x = -ridge + 2 * ridge * k / count
        wave = 0.09 * abs(sin(pi * k / per_row))
        start = max(eaves, abs(x))
        low.append((x, EAVES + 0.05 + wave + pitch * (start - eaves), -start))
        high.append((x, EAVES + 0.05 + wave + pitch * (ridge - eaves), -ridge))
        lip.append((x, low[-1][1] - 0.08 - wave, -start))
    tiles.smooth([low, high])
    tiles.smooth([lip, low])
    tiles.flat((-eaves, EAVES, -eaves), (-HALF, EAVES, -HALF), (HALF, EAVES, -HALF), (eaves, EAVES, -eaves))
    tiles.write("roof")


def paving():
    """Light slabs everywhere; a checker of dark ones and a medallion of dark and red ones lie on
    them, too thin to cast shadows."""
    light, dark, red = Mesh(), Mesh(), Mesh()
    light.flat((-HALF, 0, HALF), (HALF, 0, HALF), (HALF, 0, -HALF), (-HALF, 0, -HALF))
    slab, edge, up = 1.15, 4.6, 0.004
    count = int((HALF - 0.5) / slab)
    for i in range(-count, count):
        for j in range(-count, count):
            x, z = (i + 0.5) * slab, (j + 0.5) * slab
            if (i + j) % 2 and x * x + z * z > (edge + 1.1) ** 2:
                half = slab / 2
                dark.flat((x - half, up, z), (x, up, z + half), (x + half, up, z), (x, up, z - half))
    sectors = 36

    def at(r, k):
        return (r * sin(2 * pi * k / sectors), up, r * cos(2 * pi * k / sectors))

    def ring(mesh, inner, outer, every=1, first=0):
        for k in range(first, sectors, every):
            mesh.flat(at(inner, k), at(outer, k), at(outer, k + 1), at(inner, k + 1))

    ring(red, 0.0001, 0.35)
    ring(red, edge, edge + 0.3)
    ring(dark, edge + 0.5, edge + 0.6)
    edges = [0.6, 0.95, 1.4, 1.95, 2.6, 3.4, edge - 0.2]
    for level, (inner, outer) in enumerate(zip(edges, edges[1:])):
        ring(red if level % 2 else dark, inner, outer, 2, level % 2)
    light.write("paving_light")
    dark.write("paving_dark")
    red.write("paving_red")


def fountain():
    """Two basins about the origin, and a disc of water of radius 1."""
    stone = Mesh()
    stone.turned((0, 0, 0), [
        [(2.0, 0), (2.0, 0.12)], [(2.0, 0.12), (1.75, 0.12)], [(1.75, 0.12), (1.68, 0.5)],
        [(1.68, 0.5), (1.85, 0.56), (1.85, 0.68)], [(1.85, 0.68), (1.55, 0.68)], [(1.55, 0.68), (1.55, 0.2)],
        [(0.32, 0.2), (0.26, 0.5), (0.14, 0.75), (0.12, 1.35), (0.24, 1.5), (0.7, 1.66), (0.85, 1.84)],
        [(0.85, 1.84), (0.85, 1.9)], [(0.85, 1.9), (0.76, 1.9)], [(0.76, 1.9), (0.3, 1.72)],
        [(0.1, 1.7), (0.08, 2.2), (0.16, 2.35), (0.02, 2.55)],
    ], 24)
    stone.write("fountain")
    water = Mesh()
    water.turned((0, 0, 0), [[(1, 0), (0, 0)]], 24)
    water.write("water")


def pot():
    clay = Mesh()
    clay.turned((0, 0, 0), [
        [(0.3, 0), (0.42, 0.5), (0.44, 0.62)], [(0.5, 0.62), (0.5, 0.75)],
        [(0.5, 0.75), (0.42, 0.75)], [(0.42, 0.75), (0.0, 0.7)],
    ], 20)
    clay.turned((0, 0, 0), [[(0.44, 0.62), (0.5, 0.62)]], 20)
    clay.write("pot")


def drum():
    """The wall under the dome, about the origin."""
    stone = Mesh()
    stone.turned((0, 0, 0), [
        [(4.5, 8), (4.5, 13.6)], [(4.9, 13.6), (4.9, 14.0)], [(4.7, 14.0), (4.7, 14.5)], [(4.7, 14.5), (3.0, 14.6)],
    ], 24)
    stone.turned((0, 0, 0), [[(4.5, 13.6), (4.9, 13.6)]], 24)
    stone.write("drum")


def tower():
    """A bell tower about the origin, one storey of open arches under a pyramid."""
    wall, stone, brick, tiles = Mesh(), Mesh(), Mesh(), Mesh()
    h, floor, spring, top = 2.2, 15.5, 17.7, 19.3
    wall.box((-h, 0, -h), (h, 15.2, h), "du")
    for y in (11.0, 15.2, top):
        for reach, low, high in ((h + 0.12, y, y + 0.12), (h + 0.28, y + 0.12, y + 0.36)):
            stone.box((-reach, low, -reach), (reach, high, reach))
    front = {"wall": Mesh(), "stone": Mesh(), "brick": Mesh()}
    for middle in (-h / 2, h / 2):
        arch(front["wall"], (front["brick"], front["stone"]), middle, h / 2, spring, 0.75, 0.25, top, h)
    for x0, x1 in ((-h, -1.85), (-0.35, 0.35), (1.85, h)):
        front["wall"].box((x0, floor, h - WALL), (x1, spring, h), "du")
    for quarter in range(4):
        wall.add(front["wall"], quarter)
        stone.add(front["stone"], quarter)
        brick.add(front["brick"], quarter)
    edge, foot = h + 0.35, top + 0.36
    rim = [(-edge, foot, edge), (edge, foot, edge), (edge, foot, -edge), (-edge, foot, -edge)]
    for a, b in zip(rim, rim[1:] + rim[:1]):
        tiles.flat(a, b, (0, 23.4, 0))
    wall.write("tower_wall")
    stone.write("tower_stone")
    brick.write("tower_brick")
    tiles.write("tower_roof")


def main():
    MODELS.mkdir(parents=True, exist_ok=True)
    for part in (side, gallery, roof, paving, fountain, pot, drum, tower):
        part()


if __name__ == "__main__":
    main()

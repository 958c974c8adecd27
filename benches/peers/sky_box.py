"""The places of a cube map's six pictures on a huge box around the scene.

Each face has its outward axis, the direction of the picture's columns from left to right, and the direction of its rows
from bottom to top. The box is so large that every point of the scene is practically its centre.
"""

HALF_WIDTH = 1e6

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def minus(a):
    return (-a[0], -a[1], -a[2])


FACE_AXES = {
    "right": (X, Z, Y),
    "left": (minus(X), minus(Z), Y),
    "up": (Y, X, Z),
    "down": (minus(Y), X, Z),
    "front": (Z, minus(X), Y),
    "back": (minus(Z), minus(X), Y),
}

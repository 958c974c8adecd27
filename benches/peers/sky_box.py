"""Where the six pictures of a cube map stand on a huge box around the scene.

Each face: its outward axis, and the directions in which the picture's columns run (left to right) and its rows run
(bottom to top). The box is so large that a point of the scene counts as its centre.
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

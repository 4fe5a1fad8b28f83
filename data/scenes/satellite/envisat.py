"""Makes the mesh of satellite.toml, and finer ones: a satellite of Envisat's rough size, in metres, in the axes of its inertia tensor.

    python data/scenes/satellite/envisat.py envisat-36.obj        12 triangles of the body, 12 of plates with two sides
    python data/scenes/satellite/envisat.py envisat-1200.obj 8    the same satellite, its body and dish rounded

Body (10 x 2.8 x 2.1 m), solar array (14 x 5 m) and radar antenna (10 x 1.3 m) have the published sizes of Envisat, rounded;
where they stand, their tilts and the small dish are of our making.
"""
import sys

import numpy as np


def box(n):
    """The body; for n > 1 a tube whose cross-section is a rounded rectangle, closed by points."""
    half = np.array([5.0, 1.4, 1.05])
    centre = np.array([-5.0, 0.0, 0.0])
    if n == 1:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half + centre
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    around, rings = 3 * n, 2 * n + 6
    soft = lambda v: np.sign(v) * np.abs(v) ** 0.35  # a superellipse
    vertices, facets = [centre - [half[0], 0, 0]], []
    for i in range(rings):
        a = np.pi * (i + 1) / (rings + 1)
        for j in range(around):
            b = 2 * np.pi * (j + 0.5) / around
            vertices.append(centre + half * [soft(-np.cos(a)), soft(np.sin(a)) * soft(np.cos(b)), soft(np.sin(a)) * soft(np.sin(b))])
    vertices.append(centre + [half[0], 0, 0])
    at = lambda i, j: 1 + i * around + j % around
    for j in range(around):
        facets.append((0, at(0, j + 1), at(0, j)))
        facets.append((len(vertices) - 1, at(rings - 1, j), at(rings - 1, j + 1)))
        for i in range(rings - 1):
            facets += [(at(i, j), at(i, j + 1), at(i + 1, j)), (at(i, j + 1), at(i + 1, j + 1), at(i + 1, j))]
    return np.array(vertices), facets


def plate(centre, along, across):
    corners = [np.add(centre, i * np.array(along) + j * np.array(across)) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.array(corners), [(0, 1, 2), (0, 2, 3)]


def dish(around):
    rim = [[-9.0 + 0.45 * np.cos(a), 0.45 * np.sin(a), 2.0] for a in 2 * np.pi * np.arange(around) / around]
    return np.array([[-9.0, 0.0, 1.85]] + rim), [(0, 1 + j, 1 + (j + 1) % around) for j in range(around)]


def main(path, n=1):
    tilt = lambda degrees: np.array([0.0, np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    parts = [("body", box(n)), ("array", plate([8.0, 0.0, 0.5], [7.0, 0.0, 0.0], 2.5 * tilt(22.0))),
             ("antenna", plate([-5.0, 0.6, -1.9], [5.0, 0.0, 0.0], 0.65 * tilt(-30.0))), ("dish", dish(8 * n))]
    first = 1
    with open(path, "w") as out:
        out.write("# made by envisat.py; metres\n")
        for name, (vertices, facets) in parts:
            out.write(f"usemtl {name}\n")
            out.writelines("v {:.9g} {:.9g} {:.9g}\n".format(*v) for v in vertices)
            out.writelines("f {} {} {}\n".format(*(first + np.array(f))) for f in facets)
            first += len(vertices)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))

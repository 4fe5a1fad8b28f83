"""Surfaces of satellites as they are observed: plates, each with its own reflectance, and glints within exposures."""

import erfa
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support import ROOT

import polhode
from polhode import InputError

WAY = ROOT / "data/scenes/trajectories/toutatis-sun.oem"


def test_exposures_see_every_glint(tmp_path):
    """A plate that turns by 3 deg/s, against the mean of many instants."""
    (tmp_path / "plate.obj").write_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl p\nf 1 2 3\nf 1 3 4\n")
    earth = erfa.epv00(2458849.5, 0.0)[0]["p"]
    sun = -earth / np.linalg.norm(earth)
    axis = np.cross(sun, [0.0, 0.0, 1.0])
    axis /= np.linalg.norm(axis)  # of the rotation: across the directions to the Sun and to the observer
    q = Rotation.from_matrix(np.stack([axis, sun, np.cross(axis, sun)], 1))
    body = polhode.Body("plate", inertia=polhode.Inertia([1.0, 2.0, 3.0]), epoch="2020-01-01 TDB", q=q, omega=np.radians([3.0, 0.0, 0.0]))
    place = -Rotation.from_rotvec(0.4 * axis).apply(sun)  # of the body, as the Earth sees it
    direction = [np.arctan2(place[1], place[0])], [np.arcsin(place[2])], [1e6]
    options = dict(shape=tmp_path / "plate.obj", shape_unit="m", law="lambert", surfaces={"p": (0.5, 0.5, 2)}, geometry=False)
    flux = lambda rows: 10 ** (-0.4 * rows["magnitude"])
    turn = np.arange(0, 120, 0.005)
    bright = flux(body.motion().observe(turn, directions=[x * len(turn) for x in direction], **options))
    assert bright.max() > 1e3 * np.median(bright) and np.count_nonzero(np.diff((bright > 100 * np.median(bright)).astype(int)) > 0) == 2
    glint = turn[np.argmax(bright)]
    for exposure, off in ((2.0, 0.6), (60.0, 11.0)):
        rows = body.motion().observe([glint + off], directions=direction, exposure=exposure, **options)
        many = glint + off + exposure * ((np.arange(20_001) + 0.5) / 20_001 - 0.5)
        dense = body.motion().observe(many, directions=[x * len(many) for x in direction], **options)
        assert abs(rows["magnitude"][0] + 2.5 * np.log10(flux(dense).mean())) < 0.05, exposure
    with pytest.raises(InputError, match="where it has mirrors"):
        body.motion().observe([0.0], directions=direction, exposure=1e4, **options)
    with pytest.raises(InputError, match="Lambert's part"):
        body.motion().observe([0.0], directions=direction, **{**options, "law": "lommel-seeliger"})
    for parts, message in [((0.9, 0.9), "more than all light"), ((0.0, 1.0), "no part of the shape scatters")]:
        with pytest.raises(InputError, match=message):
            body.motion().observe([0.0], directions=direction, **{**options, "surfaces": {"p": parts}})


def test_a_satellite_with_plates():
    """The mesh of data/scenes/satellite, whose plates bound no solid: a darker array, and one that glints."""
    motion = polhode.read(ROOT / "data/bodies/envisat.toml").motion()
    options = dict(shape=ROOT / "data/scenes/satellite/envisat-36.obj", shape_unit="m", law="lambert", geometry=False)
    times = np.arange(0, 400, 2.0) - 160 * 86400
    with pytest.raises(InputError, match="the surface is open"):
        motion.observe(times, WAY, **options)
    plates = {"body": (0.5, 0), "array": (0.5, 0, 2), "antenna": (0.5, 0, 2), "dish": (0.5, 0, 2)}
    alike = motion.observe(times, WAY, surfaces=plates, **options)
    dark = motion.observe(times, WAY, surfaces={**plates, "array": (0.0, 0, 2)}, **options)
    assert np.array_equal(alike["area_m2"], dark["area_m2"]) and alike["area_m2"].max() > 20
    # Magnitudes are relative to the mean over all directions, which is less without the array: the bodies' own parts.
    flux = {name: 10 ** (-0.4 * rows["magnitude"]) for name, rows in (("alike", alike), ("dark", dark))}
    assert np.std(flux["dark"] / flux["alike"]) > 0.05
    for wrong, message in [({"wing": (1, 0)}, "no surface 'wing'; it names body, array, antenna, dish"), ({"body": (1, 0, 3)}, "1 or 2 sides"),
                           ({"body": (2, 0)}, "parts from 0 to 1")]:  # fmt: skip
        with pytest.raises(InputError, match=message):
            motion.observe(times, WAY, surfaces=wrong, **options)

"""`polhode animate`: films and glTF files of a body's motion, opened by other readers."""

import base64
import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from matplotlib import animation
from PIL import Image, ImageSequence
from scipy.spatial.transform import Rotation
from support import PROGRAM, ROOT, T_HANDLE, TOUTATIS, propagate

import polhode
from polhode import animate


def run_animate(*arguments):
    environment = {**os.environ, "POLHODE_PYTHON": sys.executable}
    return subprocess.run([PROGRAM, "animate", *map(str, arguments)], capture_output=True, text=True, env=environment)


def test_a_gif_has_the_frames_and_the_body_moves(tmp_path):
    result = run_animate(T_HANDLE, "-o", tmp_path / "a.gif", "--seconds", "1", "--turns", "1")
    assert result.returncode == 0 and result.stdout == f"{tmp_path / 'a.gif'}\n", result.stderr
    film = Image.open(tmp_path / "a.gif")
    frames = [np.asarray(frame.convert("L"), dtype=int) for frame in ImageSequence.Iterator(film)]
    assert len(frames) == 25 and film.size == (640, 640) and film.info["duration"] == 40
    changed = [np.count_nonzero(np.abs(a - b) > 40) for a, b in zip(frames, frames[1:])]
    assert min(changed) > 500
    assert frames[0][-1, -1] == 255
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gif"]


def test_an_mp4_is_one_or_becomes_a_gif_and_that_is_said(tmp_path):
    result = run_animate(T_HANDLE, "-o", tmp_path / "a.mp4", "--seconds", "0.2", "--turns", "0.2", "--style", "dark")
    assert result.returncode == 0, result.stderr
    if animation.writers.is_available("ffmpeg"):
        assert b"ftyp" in (tmp_path / "a.mp4").read_bytes()[:16]
    else:
        assert "no ffmpeg" in result.stdout and str(tmp_path / "a.gif") in result.stdout
        film = Image.open(tmp_path / "a.gif")
        assert film.n_frames == 5 and film.convert("RGB").getpixel((639, 639)) < (40, 40, 40)


def content(path):
    """The JSON and the bytes of a glTF file, by its specification alone."""
    data = path.read_bytes()
    if path.suffix == ".gltf":
        text = json.loads(data)
        return text, base64.b64decode(text["buffers"][0]["uri"].partition("base64,")[2])
    magic, version, length, size, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    size_of_bytes, kind = struct.unpack("<I4s", data[20 + size : 28 + size])
    assert kind == b"BIN\0" and 28 + size + size_of_bytes == length
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def values(text, buffer, accessor):
    accessor = text["accessors"][accessor]
    view = text["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    found = np.frombuffer(buffer, "<f4", accessor["count"] * width, view.get("byteOffset", 0))
    assert np.allclose(found.reshape(-1, width).min(axis=0), accessor["min"])
    return found.reshape(-1, width).astype(float)


@pytest.mark.parametrize("ending", ["glb", "gltf"])
def test_a_gltf_file_turns_as_the_body_does(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    result = run_animate(TOUTATIS, "-o", path, "--seconds", "4", "--turns", "2")
    assert result.returncode == 0, result.stderr
    text, buffer = content(path)
    moving = text["animations"][0]
    channel = next(c for c in moving["channels"] if text["nodes"][c["target"]["node"]]["name"] == "body")
    sampler = moving["samplers"][channel["sampler"]]
    assert channel["target"]["path"] == "rotation"
    t, q = values(text, buffer, sampler["input"])[:, 0], values(text, buffer, sampler["output"])
    assert t[0] == 0 and t[-1] == 4 and np.all(np.diff(t) > 0)
    motion = polhode.read(TOUTATIS).motion()
    length_s = 2 * 2 * np.pi / np.linalg.norm(motion(0.0).omega)
    assert text["extras"]["length_s"] == pytest.approx(length_s, rel=1e-12)
    difference = Rotation.from_quat(q).inv() * motion(t * length_s / 4).rotation
    assert difference.magnitude().max() < 1e-6
    assert np.all(np.sum(q[1:] * q[:-1], axis=1) > np.cos(np.radians(10)))  # readers go the shortest way
    # The momentum stands still, where it is.
    channel = next(c for c in moving["channels"] if "momentum" in text["nodes"][c["target"]["node"]]["name"])
    still = Rotation.from_quat(values(text, buffer, moving["samplers"][channel["sampler"]]["output"])).apply([0, 0, 1])
    wanted = polhode.read(TOUTATIS).momentum("ICRF")
    assert np.abs(still - wanted / np.linalg.norm(wanted)).max() < 1e-6


def test_another_reader_opens_the_gltf_file(tmp_path):
    """trimesh, which knows geometry and nodes: the ellipsoid has the ratios of its inertia, its axes lie where they do."""
    animate.gltf(TOUTATIS, tmp_path / "a.glb", turns=1, seconds=1)
    scene = trimesh.load(tmp_path / "a.glb")
    body = polhode.read(TOUTATIS)
    inertia = body.inertia
    corners = np.concatenate([scene.geometry[name].vertices for name in ("body", "body_1")])
    extent = np.ptp(corners @ inertia.named_from_principal, axis=0)
    assert np.allclose(extent / extent[0], inertia.ellipsoid_axis_ratios, atol=1e-6)
    solid = trimesh.util.concatenate([scene.geometry[name] for name in ("body", "body_1")])
    solid.merge_vertices(merge_norm=True, merge_tex=True)
    assert solid.is_watertight and solid.volume > 0
    turn = scene.graph.get("principal axis 1")[0][:3, :3]  # to the file's y-up axes
    up = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert np.abs(turn @ [0, 0, 1] - up @ body.motion()(0.0).rotation.apply(inertia.named_from_principal[:, 0])).max() < 1e-6


def test_of_an_ephemeris_and_of_a_mesh(tmp_path):
    fits = propagate(TOUTATIS, tmp_path / "a.fits", "--stop", "+5 d", "--step", "1 h")
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
    facets = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    film = animate.film(fits, polhode.Mesh(corners, facets), count=200)
    of_body = polhode.read(TOUTATIS).motion()(np.linspace(0, 5 * 86400, 200))
    assert (Rotation.from_quat(np.roll(film.q, -1, axis=1)).inv() * of_body.rotation).magnitude().max() < 1e-6
    radius = np.sqrt(0.5**2 + 1 + 1.5**2)
    assert np.allclose(film.vertices, (corners - [0.5, 1, 1.5]) / radius)
    wanted = polhode.read(TOUTATIS).momentum("ICRF")
    assert np.abs(film.momentum - wanted / np.linalg.norm(wanted)).max() < 1e-5
    scene = polhode.read(ROOT / "data/scenes/envisat-month.toml")
    assert animate.film(scene, count=50).q.shape == (50, 4)


@pytest.mark.parametrize(
    "arguments, said",
    [
        ((TOUTATIS, "-o", "a.avi"), ".mp4, .gif, .glb or .gltf"),
        (("nothing.toml",), "there is no file nothing.toml"),
        ((TOUTATIS, "-o", "a.gif", "--seconds", "0"), "positive"),
        ((TOUTATIS, "-o", "a.glb", "--turns", "1e9"), "a film has 2 to"),
    ],
)
def test_what_cannot_be_is_one_line(arguments, said):
    result = run_animate(*arguments)
    assert result.returncode in (2, 3) and said in result.stderr and result.stderr.count("\n") == 1, result.stderr


def test_the_dark_picture_is_dark(tmp_path):
    figure = polhode.plot.body(TOUTATIS, style="dark")
    figure.savefig(tmp_path / "a.png", dpi=40)
    light = np.asarray(Image.open(tmp_path / "a.png").convert("L"))
    assert np.median(light) < 40 and light.max() > 200
    with pytest.raises(polhode.InputError, match="light or dark"):
        animate.still(TOUTATIS, style="grey")

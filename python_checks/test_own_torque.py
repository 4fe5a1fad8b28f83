"""Torques of one's own in Python: callables, and compiled functions."""

import ctypes
import shutil
import signal
import subprocess
import sys
import threading
import time
import traceback

import numpy as np
import pytest
from support import angle_rad

import polhode

MU = 3.986004418e14
BODY = [40.0, 70.0, 90.0], [0.3, -0.5, 0.7, 0.2], [0.3, 0.9, 1.1]
TIMES = np.linspace(0.0, 3000.0, 101)


def motion(torques, tolerance_rad=1e-7, last_s=3000.0):
    return polhode.TorquedMotion(*BODY, torques, 0.0, last_s, tolerance_rad=tolerance_rad)


def apart(a, b):
    return angle_rad(a(TIMES).q, b(TIMES).q).max()


def orbit():
    return polhode.Orbit.kepler(MU, 6.9e6, 0.1, 0.0, [1, 0, 0], [0, 0.5, 0.8])


def matrix_to_body(q):
    a, b, c, d = q
    return np.array(
        [
            [a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)],
            [2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)],
            [2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d],
        ]
    )


def damping(t, q, omega):
    assert isinstance(t, float) and q.shape == (4,) and omega.shape == (3,)
    return -1e-2 * omega


def test_callables_are_as_good_as_the_librarys_own_torques():
    known = motion([polhode.Torque.damping(1e-2)], 1e-10)
    for options in {"kinks": False}, {}:
        own = motion([polhode.Torque.function(damping, **options)])
        assert own.account().method == "dormand-prince"
        assert apart(own, known) < 1e-7
    evaluations = lambda **options: motion([polhode.Torque.function(damping, **options)]).account().torque_evaluations
    assert evaluations(kinks=False) <= evaluations()
    as_lists = motion([polhode.Torque.function(lambda t, q, omega: [float(-1e-2 * w) for w in omega])])
    assert apart(as_lists, known) < 1e-7


def test_the_place_on_an_orbit_is_told():
    moments = np.array(BODY[0])

    def pull(t, q, omega, position):
        r = matrix_to_body(q) @ position
        return 3 * MU / np.linalg.norm(r) ** 5 * np.cross(r, moments * r)

    known = motion([polhode.Torque.gravity_gradient(MU, orbit())], 1e-10)
    assert apart(motion([polhode.Torque.function(pull, orbit=orbit(), kinks=False)]), known) < 1e-7
    assert apart(motion([polhode.Torque.constant([0, 0, 0])]), known) > 1e-4
    torque = polhode.Torque.function(pull, orbit=orbit())
    assert np.allclose(torque(10.0, BODY[1], [0, 0, 0], moments), polhode.Torque.gravity_gradient(MU, orbit())(10.0, BODY[1], [0, 0, 0], moments))


def test_scenes_take_them_in_named_axes():
    inertia = polhode.Inertia([80.0, 50.0, 110.0], absolute=True)
    body = polhode.Body("box", inertia=inertia, epoch="2027-01-01 TT", q=[1, 0, 0, 0], omega=[0.01, 0.002, 0.03])
    function = polhode.Torque.function(lambda t, q, omega: [0, 1e-4, -1e-3 * omega[2]], kinks=False)
    scene = polhode.Scene("box", body, [function], after="1000 s", accuracy="0.001 deg")
    plan = scene.plan()
    assert plan.effects[0].kept and plan.effects[0].secular_rad is None and scene.torque_names == ["own function"]
    known = polhode.Torque.damping([0, 0, 1e-3]), polhode.Torque.constant([0, 1e-4, 0])
    other = polhode.Scene("box", body, known, after="1000 s", accuracy="0.0001 deg").motion()
    assert angle_rad(scene.motion()(1000.0).q, other(1000.0).q).max() < np.radians(0.0011)
    tiny = polhode.Torque.function(lambda t, q, omega: [0, 0, 1e-12], largest=1e-12)
    assert not polhode.Scene("box", body, [tiny], after="1000 s", accuracy="0.001 deg").plan().effects[0].kept


class Mine(Exception):
    pass


def test_what_a_function_raises_reaches_the_caller():
    raised = Mine("at 500 s")

    def fails(t, q, omega):
        if t > 500:
            raise raised
        return np.zeros(3)

    with pytest.raises(Mine) as found:
        motion([polhode.Torque.function(fails)])
    assert found.value is raised
    assert "in fails" in "".join(traceback.format_exception(found.value))
    with pytest.raises(TypeError, match="positional argument"):
        motion([polhode.Torque.function(lambda t, q: np.zeros(3))])


@pytest.mark.parametrize(
    "answer, message",
    [
        (np.zeros((3, 1)), r"an array of the shape \(3, 1\), \(3,\) is wanted"),
        (0.0, r"an array of the shape \(\), \(3,\) is wanted"),
        ([0.0, 0.0], r"an array of the shape \(2\), \(3,\) is wanted"),
        ([0.0, np.nan, 0.0], "gave .0, nan, 0. at .* s; finite numbers are wanted"),
        ([np.inf, 0.0, 0.0], "finite numbers are wanted"),
    ],
)
def test_what_is_no_torque_is_refused(answer, message):
    with pytest.raises(polhode.InputError, match=message):
        motion([polhode.Torque.function(lambda t, q, omega: answer)])


def test_threads_may_ask():
    own = motion([polhode.Torque.function(damping)])
    times = np.linspace(0.0, 3000.0, 5000)
    assert np.array_equal(own(times).q, own(times, threads=2).q)


# --- Compiled functions ---------------------------------------------------------------------------------------------

C = """
#include <math.h>
void damping(double t, const double *q, const double *omega, const double *position, double *torque) {
  for (int i = 0; i < 3; ++i) torque[i] = -1e-2 * omega[i];
}
void pull(double t, const double *q, const double *omega, const double *p, double *torque) {
  const double a = q[0], b = q[1], c = q[2], d = q[3];
  const double r[3] = {(a * a + b * b - c * c - d * d) * p[0] + 2 * (b * c + a * d) * p[1] + 2 * (b * d - a * c) * p[2],
                       2 * (b * c - a * d) * p[0] + (a * a - b * b + c * c - d * d) * p[1] + 2 * (c * d + a * b) * p[2],
                       2 * (b * d + a * c) * p[0] + 2 * (c * d - a * b) * p[1] + (a * a - b * b - c * c + d * d) * p[2]};
  const double I[3] = {40, 70, 90}, k = 3 * 3.986004418e14 / pow(r[0] * r[0] + r[1] * r[1] + r[2] * r[2], 2.5);
  for (int i = 0; i < 3; ++i) { int j = (i + 1) % 3, l = (i + 2) % 3; torque[i] = k * (I[l] - I[j]) * r[j] * r[l]; }
}
void push(double t, const double *q, const double *omega, const double *position, double *torque) {
  torque[0] = torque[1] = 0.0;
  torque[2] = 1e-7;
}
void bad(double t, const double *q, const double *omega, const double *position, double *torque) {}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compiled")
    (folder / "torques.c").write_text(C)
    subprocess.run([shutil.which("cc") or "c++", "-O2", "-shared", "-fPIC", "-o", folder / "torques.so", folder / "torques.c", "-lm"], check=True)
    loaded = ctypes.CDLL(str(folder / "torques.so"))
    numbers = ctypes.POINTER(ctypes.c_double)
    for function in loaded.damping, loaded.pull, loaded.bad:
        function.argtypes, function.restype = [ctypes.c_double, numbers, numbers, numbers, numbers], None
    return loaded


def test_compiled_functions_are_as_good(library):
    known = motion([polhode.Torque.damping(1e-2)], 1e-10)
    assert apart(motion([polhode.Torque.compiled(library.damping, kinks=False)]), known) < 1e-7
    address = ctypes.cast(library.damping, ctypes.c_void_p).value
    assert apart(motion([polhode.Torque.compiled(address)]), known) < 1e-7
    known = motion([polhode.Torque.gravity_gradient(MU, orbit())], 1e-10)
    assert apart(motion([polhode.Torque.compiled(library.pull, orbit=orbit(), kinks=False)]), known) < 1e-7
    with pytest.raises(polhode.InputError, match="finite numbers are wanted"):
        motion([polhode.Torque.compiled(library.bad)])


def test_scipys_low_level_callables_are_taken(library):
    scipy = pytest.importorskip("scipy")
    capsule = ctypes.pythonapi.PyCapsule_New
    capsule.restype, capsule.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
    address = ctypes.cast(library.damping, ctypes.c_void_p).value
    name = b"void (double, double *, double *, double *, double *)"
    good = scipy.LowLevelCallable(capsule(address, name, None))
    assert apart(motion([polhode.Torque.compiled(good)]), motion([polhode.Torque.damping(1e-2)])) < 2e-7
    with pytest.raises(polhode.InputError, match="signature double .double. ?, "):
        polhode.Torque.compiled(scipy.LowLevelCallable(capsule(address, b"double (double)", None)))


def test_numbas_functions_are_taken():
    numba = pytest.importorskip("numba")
    numbers = numba.types.CPointer(numba.types.double)

    @numba.cfunc(numba.types.void(numba.types.double, numbers, numbers, numbers, numbers))
    def compiled(t, q, omega, position, torque):
        for i in range(3):
            torque[i] = -1e-2 * omega[i]

    assert apart(motion([polhode.Torque.compiled(compiled)]), motion([polhode.Torque.damping(1e-2)])) < 2e-7

    @numba.cfunc(numba.types.double(numba.types.double))
    def other(t):
        return t

    with pytest.raises(polhode.InputError, match="signature"):
        polhode.Torque.compiled(other)


def test_what_is_no_compiled_function_is_refused(library):
    with pytest.raises(polhode.InputError, match="found function; Torque.function takes functions of Python"):
        polhode.Torque.compiled(damping)
    with pytest.raises(polhode.InputError, match="is 0"):
        polhode.Torque.compiled(0)
    library.other = ctypes.CFUNCTYPE(None, ctypes.c_double)(lambda t: None)
    with pytest.raises(polhode.InputError, match="signature"):
        polhode.Torque.compiled(library.other)
    with pytest.raises(polhode.InputError, match="0 or more"):
        polhode.Torque.function(damping, largest=-1.0)


def test_compiled_functions_run_without_the_lock(library):
    """A thread of Python goes on while a motion is computed, in steps as small as its own."""
    counted, ended = [0], threading.Event()

    def count():
        while not ended.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    motion([polhode.Torque.compiled(library.pull, orbit=orbit())], 1e-9, 50000.0)
    during = counted[0] - before
    ended.set()
    thread.join()
    assert during > 1000


@pytest.mark.parametrize("how", ["function", "compiled"])
def test_an_interrupt_ends_a_propagation(library, how):
    code = f"""
import ctypes, polhode, sys
if {how!r} == "function":
    torque = polhode.Torque.function(lambda t, q, omega: (0.0, 0.0, 1e-7))
else:
    function = ctypes.CDLL({library._name!r}).push
    numbers = ctypes.POINTER(ctypes.c_double)
    function.argtypes, function.restype = [ctypes.c_double, numbers, numbers, numbers, numbers], None
    torque = polhode.Torque.compiled(function)
print("ready", flush=True)
try:
    polhode.TorquedMotion([40, 70, 90], [1, 0, 0, 0], [3e1, 9e1, 1.1e2], [torque], 0.0, 1e9, max_evaluations=10**12)
except KeyboardInterrupt:
    print("interrupted")
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    try:
        assert process.communicate(timeout=60)[0] == "interrupted\n"
    finally:
        process.kill()

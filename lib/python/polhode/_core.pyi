from collections.abc import Callable, Sequence
import os
from typing import Any, overload

import astropy.time
import astropy.units
import numpy
import numpy.typing
import scipy.spatial.transform


version: str = '0.1.0'

class Instant:
    """
    One instant, whatever the time scale: good to far less than a nanosecond. Instants compare, their difference is in SI seconds as TT counts them, and so is what is added to one.
    """

    def __init__(self, date: str, scale: str | None = None) -> None:
        """
        From a date: '2029-04-13T21:46:00 UTC', '2029-103T21:46 TDB', 'JD 2462240.407 TT', 'MJD 62239.9 TAI'. The scale (TT, TAI, UTC, TDB, GPS, ET) may be given apart. Raises InputError.
        """

    @staticmethod
    def from_tt_j2000(seconds: float, rest: float = 0.0) -> Instant:
        """
        From TT seconds since 2000-01-01T12:00:00 TT, in two parts that add up.
        """

    @staticmethod
    def of(when: Instant | str | astropy.time.Time) -> Instant:
        """Of an astropy Time, a date or an Instant."""

    def text(self, scale: str = 'TDB', decimals: int = 3) -> str:
        """The calendar date in a scale, correctly rounded to so many decimals."""

    def mjd(self, scale: str = 'TDB') -> tuple[float, float]:
        """
        Modified Julian date in a scale: the whole day and the fraction of that day.
        """

    def since_j2000(self, scale: str = 'TT') -> tuple[float, float]:
        """
        Seconds of a scale since 2000-01-01T12:00:00 on that scale, in two parts.
        """

    @property
    def utc_doubt(self) -> str | None:
        """
        Why UTC is in doubt at this instant, or None: before 1960, or years beyond the last known leap second.
        """

    def to_astropy(self) -> astropy.time.Time:
        """As a Time, in TT."""

    @overload
    def __sub__(self, arg: Instant, /) -> float: ...

    @overload
    def __sub__(self, arg: float, /) -> Instant: ...

    def __add__(self, arg: float, /) -> Instant: ...

    def __eq__(self, other: object, /) -> bool: ...

    def __lt__(self, arg: Instant, /) -> bool: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

def leap_seconds() -> list[tuple[int, int, float]]:
    """
    The table in use: (year, month, TAI - UTC in seconds from the first day of that month on).
    """

def set_leap_seconds(kernel: str | os.PathLike[str]) -> None:
    """
    Takes the table of leap seconds of a NAIF leap-second kernel, for the whole process. Call it before anything is read or converted. Raises InputError, FileError.
    """

def frame_rotation(from_frame: str, to_frame: str, at: Instant | str | astropy.time.Time | Sequence[Instant | str] | None = None, ut1_minus_utc_s: float = 0.0, pole_x_arcsec: float = 0.0, pole_y_arcsec: float = 0.0) -> numpy.typing.NDArray[numpy.float64]:
    """
    The rotation v_to = q v_from q* between two frames (ICRF, GCRF, EME2000, ECLIPJ2000, ECLIPIAU2006, TEME, ITRF) as a quaternion, scalar first: shape (4,), or (n, 4) for n instants. TEME and ITRF need `at`.
    """

class Inertia:
    """
    Inertia about the centre of mass. Motion without torques needs the ratios of the moments only; torques need kg m2 (`absolute`).
    """

    def __init__(self, moments: numpy.typing.ArrayLike, products: numpy.typing.ArrayLike | None = None, *, sign: str = 'tensor elements', absolute: bool = False) -> None:
        """
        From moments (Ixx, Iyy, Izz) and products (Ixy, Ixz, Iyz) in the body's named axes. `sign` says what the products are: 'tensor elements' or 'positive integrals' of x y dm, which are minus those. Raises InputError for what no body has.
        """

    @staticmethod
    def from_tensor(tensor: numpy.typing.ArrayLike, *, absolute: bool = False) -> Inertia:
        """From a symmetric tensor, shape (3, 3)."""

    @property
    def principal_moments(self) -> numpy.typing.NDArray[numpy.float64]:
        """I1 <= I2 <= I3, shape (3,)"""

    @property
    def named_from_principal(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        The principal axes, as columns, in the named axes: v_named = R v_principal. Shape (3, 3).
        """

    @property
    def tensor(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        In the named axes, about the centre of mass: shape (3, 3), so that momentum = tensor @ omega.
        """

    @property
    def absolute(self) -> bool:
        """Whether the moments are in kg m2."""

    @property
    def ellipsoid_axis_ratios(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Semi-axes of the homogeneous ellipsoid with these moments, as parts of the longest.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class Mesh:
    """
    A closed surface of triangles, corners counter-clockwise seen from outside.
    """

    def __init__(self, vertices: numpy.typing.ArrayLike, facets: numpy.typing.ArrayLike) -> None:
        """
        From vertices of shape (n, 3) and facets of shape (m, 3): indices from 0.
        """

    @property
    def vertices(self) -> numpy.typing.NDArray[numpy.float64]:
        """Shape (n, 3), in the file's unit of length."""

    @property
    def facets(self) -> numpy.typing.NDArray[numpy.uint32]:
        """Shape (m, 3), indices from 0."""

    def mass_properties(self) -> MassProperties:
        """
        Of the solid of density 1 that the mesh bounds. Raises InputError for one that bounds none, naming facets.
        """

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class MassProperties:
    """Of a solid of density 1, in the axes and unit of its mesh."""

    @property
    def volume(self) -> float: ...

    @property
    def centre_of_mass(self) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def inertia_about_centre(self) -> numpy.typing.NDArray[numpy.float64]:
        """The tensor, shape (3, 3)."""

    @property
    def shells(self) -> int:
        """Closed surfaces, cavities included."""

    def __repr__(self) -> str: ...

def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """
    A mesh in OBJ, PLY, STL or DAMIT's shape.txt, by content. Raises InputError, FileError.
    """

class SpinSolution:
    """A tumbling motion that has published periods."""

    @property
    def long_axis_mode(self) -> bool: ...

    @property
    def energy(self) -> float:
        """E/E0 = 2 E I3 / L^2"""

    @property
    def separatrix_distance(self) -> float:
        """0 on the separatrix, 1 farthest"""

    @property
    def momentum(self) -> float:
        """L, unit of the moments times rad/s"""

    @property
    def momentum_at_psi_zero(self) -> numpy.typing.NDArray[numpy.float64]:
        """In principal axes, where psi = 0. Shape (3,)."""

    def state(self, inertia: Inertia, phi_rad: float, psi_rad: float, convention: str = 'long axis', theta_above_90_deg: bool = False) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], float]:
        """
        The state at these angles: q from principal axes to axes with z along L (scalar first), L in principal axes, and the angle theta between L and the convention's axis.
        """

def solve_periods(inertia: Inertia, precession_period_s: float, rotation_period_s: float, convention: str = 'long axis', long_axis_mode: bool | None = None) -> list[SpinSolution]:
    """
    The motions with these periods P_phi and P_psi as light-curve papers publish them ('long axis' or 'short axis' convention of Samarasinha & Mueller 2015): one, or one in each mode, short-axis mode first. Raises InputError where there is none.
    """

def energy_at(inertia: Inertia, theta_rad: float, psi_rad: float, convention: str = 'long axis') -> float:
    """E/E0 of the state with these angles of the convention."""

def q_frame_from_momentum(longitude_rad: float, latitude_rad: float) -> numpy.typing.NDArray[numpy.float64]:
    """
    v_frame = q v_momentum q*, of axes with z along that direction and x in the plane of it and the frame's z axis.
    """

def q_from_euler(sequence: str, angles_rad: numpy.typing.ArrayLike | astropy.units.Quantity) -> numpy.typing.NDArray[numpy.float64]:
    """
    The attitude v_frame = q v_body q* of Euler angles about moving axes, 'ZXZ' or '313' (12 sequences): scalar first.
    """

def euler_angles(sequence: str, q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation) -> numpy.typing.NDArray[numpy.float64]:
    """The three angles of an attitude, rad; the inverse of q_from_euler."""

def omega_from_euler_rates(sequence: str, angles_rad: numpy.typing.ArrayLike | astropy.units.Quantity, rates_rad_s: numpy.typing.ArrayLike | astropy.units.Quantity) -> numpy.typing.NDArray[numpy.float64]:
    """Angular velocity in body axes of angles that change at these rates."""

def euler_rates(sequence: str, angles_rad: numpy.typing.ArrayLike | astropy.units.Quantity, omega: numpy.typing.ArrayLike | astropy.units.Quantity) -> numpy.typing.NDArray[numpy.float64]:
    """The rates of the angles; the inverse of omega_from_euler_rates."""

class Body:
    """
    A rigid body: inertia, and its spin state at an epoch. `read` makes one from a file; what is not known is None.
    """

    def __init__(self, name: str, *, inertia: Inertia | None = None, epoch: Instant | str | astropy.time.Time | None = None, frame: str = 'ICRF', q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation | None = None, omega: numpy.typing.ArrayLike | astropy.units.Quantity | None = None, source: str = '', id: str = '', period_uncertainty: float | None = None) -> None:
        """
        Without a file. q: attitude at the epoch, v_frame = q v_named q*, scalar first, or a scipy Rotation (any length but 0). omega: rad/s in the named axes. period_uncertainty: one sigma of the periods, as a part of them. Raises InputError.
        """

    @property
    def name(self) -> str: ...

    @property
    def id(self) -> str: ...

    @property
    def source(self) -> str: ...

    @property
    def inertia(self) -> Inertia | None: ...

    @property
    def epoch(self) -> Instant | None: ...

    @property
    def frame(self) -> str | None:
        """That the state refers to."""

    @property
    def q(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """v_frame = q v_named q* at the epoch, scalar first, shape (4,)."""

    @property
    def omega(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """rad/s at the epoch, named axes, shape (3,)."""

    def momentum(self, frame: str = 'ICRF') -> numpy.typing.NDArray[numpy.float64]:
        """
        Angular momentum in an inertial frame, unit of inertia times rad/s, shape (3,).
        """

    @property
    def period_uncertainty(self) -> float | None: ...

    @property
    def missing(self) -> list[str]:
        """What a motion would need and is not known; empty: nothing."""

    @property
    def notes(self) -> list[str]:
        """What was understood."""

    @property
    def warnings(self) -> list[str]:
        """What was assumed or looks doubtful."""

    @property
    def history(self) -> AttitudeHistory | None:
        """The attitude history of the same file, or None."""

    @property
    def path(self) -> str:
        """Of the file; empty: there was none."""

    def info(self) -> dict[str, Any]:
        """
        Mode, periods, invariants, axes, warnings: what `polhode info --json` prints, as a dict.
        """

    def motion(self, frame: str = 'ICRF', method: str = 'auto') -> Motion:
        """
        The free motion in an inertial frame. Raises InputError naming what the body lacks.
        """

    def __repr__(self) -> str: ...

    @property
    def uncertainty(self) -> Uncertainty | None:
        """Of its published numbers; None: they count as exact."""

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Of (theta0, m0, I) at the epoch, shape (9, 9): a small turn of the principal axes and a change of the momentum along them, both given in the named axes, and the principal moments: what Motion.partials() takes derivatives by. Raises InputError for a body without uncertainties.
        """

    def known_until(self, angle: float | str | astropy.units.Quantity) -> float:
        """
        The first second after the epoch at which one sigma of the attitude is larger than the angle (rad, or '1 deg'), by the uncertainties, without torques; inf: never. Raises InputError for a body without uncertainties.
        """

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

def read(path: str | os.PathLike[str]) -> Any:
    """
    What a file holds, by its content: a Scene, an AttitudeHistory (tables and messages of attitudes), or a Body (every other format; its `history` has the attitudes that stand beside a complete body). FILE#ROW is a row of a table of bodies. Raises InputError with file and line, FileError.
    """

def input_formats() -> list[str]:
    """The formats that `read` recognises."""

class Orbit:
    """
    The way of a body about another mass, from that mass, in inertial axes.
    """

    @staticmethod
    def kepler(mu: float, periapsis_m: float, eccentricity: float, periapsis_time_s: float, to_periapsis: numpy.typing.ArrayLike, normal: numpy.typing.ArrayLike) -> Orbit:
        """
        Ellipse, parabola or hyperbola: mu in m3/s2, the time of periapsis in seconds from the body's epoch, the directions of periapsis and of the orbit's normal. Raises InputError.
        """

    @staticmethod
    def table(times_s: numpy.typing.ArrayLike, positions_m: numpy.typing.ArrayLike, velocities_m_s: numpy.typing.ArrayLike | None = None, degree: int = 7) -> Orbit:
        """
        From positions (n, 3) and perhaps velocities (n, 3) at times in seconds from the body's epoch: interpolated by Hermite's polynomials of that degree, without velocities by Lagrange's.
        """

    @staticmethod
    def read(path: str | os.PathLike[str], centre: str, epoch: Instant | str | astropy.time.Time, frame: str = 'ICRF', table_frame: str | None = None) -> Orbit:
        """
        From a CCSDS OEM or a table: about `centre`, in an inertial frame, for a body with this epoch. `table_frame` is that of a table of text, if not `frame`. Raises InputError, FileError.
        """

    def __call__(self, t_s: float) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """Position (m) and velocity (m/s) at seconds from the body's epoch."""

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class Torque:
    """
    What turns a body from outside, or loses its energy. Vectors and tensors in "body axes" are in the axes that the body's inertia is named in; times are seconds from its epoch.
    """

    @staticmethod
    def gravity_gradient(mu: float, orbit: Orbit) -> Torque:
        """Of a point mass (mu in m3/s2) on the body's second moments."""

    @staticmethod
    def constant(torque: numpy.typing.ArrayLike, axes: str = 'body') -> Torque:
        """N m, in 'body' axes or in those of the inertial 'frame'."""

    @staticmethod
    def pulse(start_s: float, duration_s: float, torque: numpy.typing.ArrayLike) -> Torque:
        """N m in body axes while a thruster fires."""

    @staticmethod
    def damping(coefficients: numpy.typing.ArrayLike) -> Torque:
        """
        Torque -D omega: D in N m s as one number, three along the body axes, or a matrix.
        """

    @staticmethod
    def eddy_currents(magnetic_tensor: numpy.typing.ArrayLike, dipole_axis: numpy.typing.ArrayLike, dipole_t_m3: float, orbit: Orbit) -> Torque:
        """
        Of a dipole's field in a conductor: tensor in S m4 (body axes), the dipole's direction (southward for the Earth), its field on the equator times the distance cubed (Earth 7.8e15 T m3).
        """

    @staticmethod
    def dissipation(quality_factor: float, principal_moments: numpy.typing.ArrayLike, momentum: float) -> Torque:
        """
        Loss of energy inside a body of these moments and this length of the momentum: by 2 pi/Q of itself per turn.
        """

    @staticmethod
    def sunlight(mesh: Mesh, orbit: Orbit, specular: numpy.typing.ArrayLike = 0.0, diffuse: numpy.typing.ArrayLike = 1.0, *, centre_of_mass: numpy.typing.ArrayLike | None = None, sides: numpy.typing.ArrayLike = 1.0, shadow: Orbit | None = None, shadow_radius_m: float = 6378137.0) -> Torque:
        """
        Pressure of light and of reflected light and heat on a mesh in metres, in body axes; `orbit` from the Sun. Shares of the light mirrored and scattered, and whether 1 or 2 sides of a facet are lit: of all facets, or one of each. `centre_of_mass` in the mesh's coordinates, if not their origin. `shadow`: the orbit about a planet of this radius that eclipses the Sun.
        """

    @staticmethod
    def aerodynamic(mesh: Mesh, orbit: Orbit, *, density_kg_m3: float, distance_m: float, scale_height_m: float, turn_rad_s: numpy.typing.ArrayLike, accommodation: numpy.typing.ArrayLike = 1.0, rebound_speed: numpy.typing.ArrayLike = 0.0, centre_of_mass: numpy.typing.ArrayLike | None = None, sides: numpy.typing.ArrayLike = 1.0) -> Torque:
        """
        Of thin air that meets the facets of a mesh: its density at a distance from the planet's centre, which falls by e in every scale height, and the rate at which it turns with the planet (rad/s, inertial axes). Of the molecules the share `accommodation` leaves scattered, at `rebound_speed` of the speed with which they came; the rest is mirrored. `orbit` from the planet; the mesh, `centre_of_mass` and `sides` as for `sunlight`.
        """

    @staticmethod
    def function(function: Callable[..., numpy.typing.ArrayLike], *, orbit: Orbit | None = None, kinks: bool = True, largest: float | None = None) -> Torque:
        """
        Of your own: function(t_s, q, omega) gives three numbers, N m in body axes; with an orbit function(t_s, q, omega, position_m). t_s is a float, q (4,) scalar first from body to inertial axes, omega (3,) in rad/s in body axes, the position (3,) in inertial axes. Say kinks=False of a function that is smooth in all of them: it is then evaluated less often. `largest`: no torque of it is larger, for plans.
        """

    @staticmethod
    def compiled(function: Any, *, orbit: Orbit | None = None, kinks: bool = True, largest: float | None = None) -> Torque:
        """
        The same by machine code, called without the interpreter's lock: a numba cfunc, a ctypes function pointer, a scipy LowLevelCallable, or an address, of void f(double t_s, const double *q, const double *omega, const double *position_m, double *torque). The position is null without an orbit.
        """

    @property
    def name(self) -> str: ...

    def __call__(self, t_s: float, q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation, omega: numpy.typing.ArrayLike | astropy.units.Quantity, principal_moments: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        The torque from outside at a time, attitude and rate, body axes being the principal ones. Shape (3,).
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class PlannedEffect:
    """What one torque can do over a span, from above, and what became of it."""

    @property
    def name(self) -> str: ...

    @property
    def periodic_rad(self) -> float | None:
        """Swing within a turn; None for a body at rest."""

    @property
    def secular_rad(self) -> float | None:
        """Bound at the end of the span; None for a body at rest."""

    @property
    def kept(self) -> bool: ...

    @property
    def why(self) -> str: ...

    def __repr__(self) -> str: ...

class Plan:
    """The cheapest sufficient model of a motion, and what is expected of it."""

    @property
    def effects(self) -> list[PlannedEffect]: ...

    @property
    def model(self) -> str: ...

    @property
    def why(self) -> str: ...

    @property
    def error_rad(self) -> float:
        """At the most, if the propagation succeeds."""

    @property
    def dropped_rad(self) -> float:
        """Bound of all dropped effects together."""

    @property
    def tolerance_rad(self) -> float:
        """Of the propagation, if torques are kept."""

    @property
    def torque_evaluations(self) -> float | None:
        """Expected within a factor of 2; None: it cannot be told."""

    @property
    def cost_why(self) -> str: ...

    @property
    def sensitivity(self) -> float:
        """rad of attitude at the end per relative change of the momentum."""

    def __repr__(self) -> str: ...

class Scene:
    """A body, what acts on it, over which span, and how well it is wanted."""

    def __init__(self, name: str, body: Body, torques: Sequence[Torque], *, frame: str = 'ICRF', before: float | str | astropy.units.Quantity = 0.0, after: float | str | astropy.units.Quantity = 0.0, accuracy: float | str | astropy.units.Quantity, source: str = '') -> None:
        """
        Without a file: a complete body, torques, the span before and after its epoch (s, or '30 d'), the wanted accuracy of the attitude (rad, or '0.1 deg'). Raises InputError.
        """

    @property
    def name(self) -> str: ...

    @property
    def source(self) -> str: ...

    @property
    def body(self) -> Body: ...

    @property
    def frame(self) -> str: ...

    @property
    def torques(self) -> list[Torque]: ...

    @property
    def torque_names(self) -> list[str]:
        """With the names of their orbits."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last second, from the epoch."""

    @property
    def accuracy_rad(self) -> float: ...

    @property
    def path(self) -> str: ...

    def plan(self, full: bool = False) -> Plan:
        """
        Which effects matter, by bounds, and which model; `full` keeps every effect, at 1e-9 rad. Raises InputError.
        """

    def motion(self, full: bool = False, max_evaluations: int | None = None) -> Motion:
        """
        The motion as planned, over the span. Raises InputError, and ComputationError where the planned error is not reached within so many torque evaluations.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class State:
    """
    Attitude, rate and momentum at a time or an array of times: arrays of the shape of the times (bodies and times broadcast against each other), and one more axis.
    """

    @property
    def q(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Attitude, v_frame = q v_body q*, scalar first: (..., 4). Its sign is continuous in time.
        """

    @property
    def omega(self) -> numpy.typing.NDArray[numpy.float64]:
        """Angular velocity, rad/s, body axes: (..., 3)."""

    @property
    def momentum(self) -> numpy.typing.NDArray[numpy.float64]:
        """Angular momentum, body axes: (..., 3). `units` says in what."""

    @property
    def rotation(self) -> scipy.spatial.transform.Rotation:
        """
        The attitude as a scipy Rotation from the body to the frame; more than one axis of rows becomes one.
        """

    @property
    def t(self) -> float | numpy.typing.NDArray[numpy.float64]:
        """The times, in seconds from the epoch, as TT counts them."""

    @property
    def epoch(self) -> Instant | None:
        """From which the times count, or None."""

    @property
    def frame(self) -> str | None:
        """The inertial frame of the attitude, or None."""

    @property
    def axes(self) -> str:
        """The body axes: 'named' in the body's file, or 'principal'."""

    @property
    def units(self) -> dict[str, str]: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[tuple[str, bytes], object, object, object, object]: ...

    def __setstate__(self, arg: tuple[tuple[str, bytes], object, object, object, object], /) -> None: ...

class Account:
    """What was done to compute a motion, and what it promises."""

    @property
    def method(self) -> str: ...

    @property
    def max_error_rad(self) -> float | None:
        """Promised for the attitude; None: nothing is."""

    @property
    def error_meaning(self) -> str: ...

    @property
    def torque_evaluations(self) -> int: ...

    def __repr__(self) -> str: ...

class Motion:
    """
    The motion of a body, built once and answered at any time. `Body.motion` and `Scene.motion` make it in named axes; FreeMotion and TorquedMotion in principal ones. Several threads may ask.
    """

    @overload
    def __call__(self, t: float, /) -> State: ...

    @overload
    def __call__(self, t: Any, *, out: tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None] | None = None, threads: int = 1) -> State:
        """
        The state at t: seconds from the epoch (TT), an Instant, a date, an astropy Time, TimeDelta or Quantity, of any shape. An array of bodies is broadcast against the times by numpy's rules. `out` is a pair of float64 arrays (..., 4) and (..., 3) that attitude and momentum are written to, the second or None. `threads` of the processor are used, 0: all; the results are the same bits. The attitude is NaN where t is; a motion under torques raises InputError outside of its span.
        """

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the array of bodies; (): one body."""

    @property
    def epoch(self) -> Instant | None:
        """Where t = 0, or None."""

    @property
    def frame(self) -> str | None:
        """The inertial frame, or None."""

    @property
    def axes(self) -> str:
        """
        The body axes of the states: 'named' in the body's file, or 'principal'.
        """

    @property
    def span(self) -> tuple[float, float] | None:
        """First and last second that a scene's motion answers; None: any."""

    def account(self, first: Any = 0.0, last: Any = 0.0) -> Account:
        """Method, promised error between two times, cost."""

    def next_flip(self, after: Any = 0.0) -> float:
        """
        The first second after `after` at which the middle axis passes the plane across the momentum; inf: never. Of a free motion.
        """

    def next_pass(self, axis: numpy.typing.ArrayLike, direction: numpy.typing.ArrayLike, within: float | str | astropy.units.Quantity, after: Any, until: Any) -> tuple[float, float] | None:
        """
        When the body axis first comes within an angle of an inertial direction, and the angle then: (s, rad), or None. Of a free motion.
        """

    def mean_rates(self) -> dict[str, float]:
        """Of a free motion, in closed form."""

    def partials(self, t: Any, *, threads: int = 1) -> numpy.typing.NDArray[numpy.float64]:
        """
        Partial derivatives of the motion at t, an array (..., 6, 9): rows theta (a small turn of the attitude in body axes, rad) and the momentum; columns the same two at the epoch, and the principal moments I1 <= I2 <= I3; under torques also their parameters, as partial_columns names them. In the axes of the states. A derivative by a moment holds attitude and momentum at the epoch, so that the rate changes. Of a free motion they are exact.
        """

    @property
    def partial_columns(self) -> list[str]:
        """Names of the columns of partials()."""

    def condition_number(self, t: Any) -> float:
        """
        How far the attitude moves, in rad, per relative change of a moment or of the momentum, at t.
        """

    def __repr__(self) -> str: ...

    def observe(self, times: Any, target: Orbit | str | os.PathLike[str] | None = None, *, observer: Orbit | str | os.PathLike[str] = 'geocentre', sun: Orbit | str | os.PathLike[str] | None = None, site: tuple[float, float, float] | None = None, directions: tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike, numpy.typing.ArrayLike] | None = None, centre: str = 'Sun', trajectory_frame: str | None = None, ut1_minus_utc_s: float = 0.0, pole_x_arcsec: float = 0.0, pole_y_arcsec: float = 0.0, convention: str = 'long-axis', frame: str = 'ECLIPJ2000', shape: Mesh | str | os.PathLike[str] | numpy.typing.ArrayLike | None = None, shape_unit: str | None = None, surfaces: dict[str, tuple[float, ...]] | None = None, law: str = 'lommel-seeliger', lambert_weight: float = 0.1, specular: float = 0.0, H: float | None = None, hg1g2: tuple[float, float] | None = None, phase_polynomial: tuple[float, float] | None = None, exposure: float | str | astropy.units.Quantity | None = None, geometry: bool = True, threads: int = 0, covariance: bool = False) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        What an observer sees at times of reception: the columns of `polhode observe` as arrays of the times' shape. `target`, `observer` and `sun` are trajectories, files or Orbits (in the motion's frame, about `centre`, seconds from its epoch); the observer may be 'geocentre', 'sun', or a `site` (longitude and latitude in deg, height in m). Instead of a target `directions` may give its astrometric geocentric right ascension and declination (rad) and distance (m). A `shape` (semi-axes in m along the body's x, y, z, text as on the command line, or a Mesh or its file with `shape_unit`) adds magnitude and area_m2; `surfaces` has of those that the mesh names the parts of light that they scatter by the law and throw on like mirrors, and, of plates, 2 for their sides. `geometry=False` leaves all else away. `covariance` adds sigma_... of each column that depends on the attitude, by the body's uncertainties.
        """

    def observe_partials(self, times: Any, target: Orbit | str | os.PathLike[str] | None = None, *, observer: Orbit | str | os.PathLike[str] = 'geocentre', sun: Orbit | str | os.PathLike[str] | None = None, site: tuple[float, float, float] | None = None, directions: tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike, numpy.typing.ArrayLike] | None = None, centre: str = 'Sun', trajectory_frame: str | None = None, ut1_minus_utc_s: float = 0.0, pole_x_arcsec: float = 0.0, pole_y_arcsec: float = 0.0, convention: str = 'long-axis', frame: str = 'ECLIPJ2000', shape: Mesh | str | os.PathLike[str] | numpy.typing.ArrayLike | None = None, shape_unit: str | None = None, surfaces: dict[str, tuple[float, ...]] | None = None, law: str = 'lommel-seeliger', lambert_weight: float = 0.1, specular: float = 0.0, H: float | None = None, hg1g2: tuple[float, float] | None = None, phase_polynomial: tuple[float, float] | None = None, exposure: float | str | astropy.units.Quantity | None = None, geometry: bool = True, threads: int = 0) -> tuple[list[str], dict[str, numpy.typing.NDArray[numpy.float64]]]:
        """
        Partial derivatives of the columns of observe(), with the same arguments: the names of the parameters, and of each column an array (..., parameters) in its unit per theirs. The parameters are those of partials(), then 'axes_x', 'axes_y', 'axes_z', a turn of the principal axes in the body (rad), whose motion stays, and, with a shape, 'scale', the relative change of its lengths. Differences across 2e-3 rad at most by the state at emission, exact by the parameters; nan where a column has no derivative, at rest or at a pole.
        """

    def ephemeris(self, start: Any = None, stop: Any = None, *, step: float | str | astropy.units.Quantity | None = None, count: int | None = None, tolerance: float | str | astropy.units.Quantity | None = None, times: Any = None, scale: str = 'TDB', covariance: bool = False) -> Ephemeris:
        """
        Rows from `start` (the epoch, or where the scene begins, unless said) to `stop` (a scene's end unless said): a step apart (s, or '10 min'), `count` of them, or as few as keep what readers of the file interpolate within a tolerance (rad, or '1 arcsec'; a scene's accuracy unless said); or at `times`, in any order. A time is seconds from the epoch (TT), a date, an Instant, an astropy Time, or '+30 d' from the epoch, for `stop` from the start. `scale` is that of the rows. covariance: that of the attitude too, of a body with uncertainties. Raises InputError.
        """

    def covariance(self, t: Any, *, threads: int = 1) -> numpy.typing.NDArray[numpy.float64]:
        """
        Of the attitude at t, rad^2, an array (..., 3, 3): of a small turn in body axes, to first order, by the body's uncertainties. Raises InputError for a body without.
        """

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

def FreeMotion(moments: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation, momentum: numpy.typing.ArrayLike, *, method: str = 'auto', threads: int = 1) -> Motion:
    """
    The free motion of a body, or of an array of them, in their principal axes. moments (..., 3): I1 <= I2 <= I3, any unit; q (..., 4): attitude at t = 0, scalar first, body to inertial, any length but 0, or a scipy Rotation; momentum (..., 3), principal axes. The leading axes are broadcast. Raises InputError.
    """

def TorquedMotion(moments: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation, momentum: numpy.typing.ArrayLike, torques: Sequence[Torque], first_s: float, last_s: float, *, tolerance_rad: float = 1e-09, method: str = 'auto', max_evaluations: int | None = None) -> Motion:
    """
    The motion of a body under torques in its principal axes over a span that holds 0, to an error of `tolerance_rad`. Raises InputError, and ComputationError where that is not reached.
    """

def methods() -> list[dict[str, str]]:
    """
    The methods of the free motion, the recommended first. (The program's `methods` lists those that they are measured against as well.)
    """

class Case:
    """
    A body in its principal axes at t = 0, torques, and wanted times: a case file.
    """

    @property
    def moments(self) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def q(self) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def momentum(self) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def torques(self) -> list[Torque]: ...

    @property
    def times(self) -> numpy.typing.NDArray[numpy.float64]: ...

    def motion(self, *, tolerance_rad: float = 1e-12, method: str = 'auto', max_evaluations: int | None = None) -> Motion:
        """Its motion over the wanted times, as `polhode eval` computes it."""

def read_case(path: str | os.PathLike[str]) -> Case:
    """A case file. Raises InputError with file and line, FileError."""

class Ephemeris:
    """Rows of attitudes, computed when they are written or asked for."""

    def write(self, path: str | os.PathLike[str], *, format: str | None = None, momentum: bool = False, adm: str = '', attitude_type: str = '', euler_sequence: str = '') -> int:
        """
        Writes a file, whose ending says the format (.fits, .fits.gz, .aem, .xml, .acm, .csv, .ecsv, .jsonl) unless `format` does; returns the number of rows. momentum: that too, in tables. adm, attitude_type, euler_sequence: of CCSDS messages. The file appears whole or not at all. Raises InputError, FileError, ComputationError.
        """

    def arrays(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        The rows as arrays: time_s, seconds of the scale from `reference`; q, scalar first; omega; momentum; in named axes; if asked for, sigma (rad) and covariance (n, 6; xx, xy, xz, yy, yz, zz). Rows of a tolerance are spaced for great circles.
        """

    @property
    def reference(self) -> Instant:
        """The instant from which `arrays` counts time_s."""

    @property
    def description(self) -> dict[str, Any]:
        """What its files say about it."""

def write(ephemerides: Sequence[Ephemeris], path: str | os.PathLike[str], *, format: str | None = None, momentum: bool = False, adm: str = '', attitude_type: str = '', euler_sequence: str = '') -> int:
    """As Ephemeris.write, for several as the segments of one CCSDS message."""

def endings() -> str:
    """The endings of files that `write` knows, in words."""

class Segment:
    """Rows of an attitude history that belong together."""

    @property
    def frame(self) -> str:
        """As the file names it."""

    @property
    def body_axes(self) -> str:
        """As the file names them."""

    @property
    def epoch(self) -> Instant:
        """The first row's instant."""

    @property
    def t(self) -> numpy.typing.NDArray[numpy.float64]:
        """Seconds from `epoch`: (n,)."""

    @property
    def q(self) -> numpy.typing.NDArray[numpy.float64]:
        """v_frame = q v_body q*, scalar first: (n, 4)."""

    @property
    def omega(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """rad/s, body axes: (n, 3); None without rates."""

    @property
    def usable(self) -> tuple[Instant, Instant]:
        """First and last instant at which an attitude may be asked for."""

    @property
    def interpolation(self) -> tuple[str, int]:
        """LINEAR, LAGRANGE or HERMITE, and the degree."""

    def __len__(self) -> int: ...

class AttitudeHistory:
    """
    An attitude given by rows: a table, or a CCSDS message. `read` makes one from a file.
    """

    def __init__(self, object: str, times: object, q: numpy.typing.ArrayLike | scipy.spatial.transform.Rotation, omega: numpy.typing.ArrayLike | astropy.units.Quantity | None = None, *, frame: str = 'ICRF', body_axes: str = 'SC_BODY_1', scale: str = 'UTC') -> None:
        """
        Without a file: instants that increase (an astropy Time, or a list of Instants or dates), attitudes (n, 4) and perhaps rates (n, 3). `scale` is that of its rows where it is written. Raises InputError.
        """

    @property
    def object(self) -> str: ...

    @property
    def scale(self) -> str:
        """Time scale of the file."""

    @property
    def segments(self) -> list[Segment]: ...

    @property
    def epoch(self) -> Instant:
        """The first row's instant, from which t counts."""

    @property
    def rows(self) -> int:
        """Of all segments."""

    @property
    def notes(self) -> list[str]: ...

    @property
    def warnings(self) -> list[str]: ...

    @property
    def body(self) -> Body:
        """What the file says of the body; mostly without inertia."""

    @property
    def path(self) -> str: ...

    def info(self) -> dict[str, Any]:
        """What `polhode info --json` prints, as a dict."""

    def __call__(self, t: Any) -> State:
        """
        Attitude and rate at t by the history's own interpolation: seconds from `epoch`, Instants, dates, astropy Times. Raises InputError outside of the rows.
        """

    def ephemeris(self, start: Any = None, stop: Any = None, *, step: float | str | astropy.units.Quantity | None = None, count: int | None = None, times: Any = None, scale: str | None = None, frame: str | None = None) -> Ephemeris:
        """
        Its rows between two times, or attitudes a step apart, or `count` in each segment, or at these times.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[str, bytes]: ...

    def __setstate__(self, arg: tuple[str, bytes], /) -> None: ...

class Difference:
    """Between two attitudes over time."""

    @property
    def compared(self) -> int:
        """Rows that have a counterpart."""

    @property
    def outside(self) -> int:
        """Rows that have none."""

    @property
    def largest_rad(self) -> float: ...

    @property
    def root_mean_square_rad(self) -> float: ...

    @property
    def time_of_largest(self) -> Instant: ...

    def __repr__(self) -> str: ...

def compare(a: AttitudeHistory | Body | Motion, b: AttitudeHistory | Body | Motion) -> Difference:
    """
    The angle between two attitudes: histories, or a history and a Body's free motion or any Motion; at the times of the history, a's if both are. Raises InputError where they cannot be related.
    """

class Uncertainty:
    """How well the published numbers of a body are known."""

    @property
    def names(self) -> list[str]:
        """
        Of the numbers that are not exact, as in body files: 'components.x', 'P_phi'.
        """

    @property
    def values(self) -> numpy.typing.NDArray[numpy.float64]:
        """As published, in the file's units, shape (n,)."""

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """Of the values, shape (n, n)."""

    def body(self, values: numpy.typing.ArrayLike) -> Body:
        """
        The body with these values in the place of the published ones: a clone, if they are drawn. Raises InputError where no body has them.
        """

    def __repr__(self) -> str: ...

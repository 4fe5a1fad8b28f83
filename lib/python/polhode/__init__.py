"""The attitude of tumbling rigid bodies: asteroids, comets, satellites, rocket stages.

    import polhode
    body = polhode.read("toutatis.toml")
    motion = body.motion(frame="ICRF")
    state = motion("1993-01-01T00:00 UTC")
    state.q, state.omega, state.momentum, state.rotation

Angles are radians, times seconds, unless a text or an astropy Quantity says its unit. A quaternion is scalar first and
maps components from the body to the frame: v_frame = q v_body q*. numpy is needed; astropy and scipy only by what is
asked for in their types.
"""

from typing import TYPE_CHECKING, Any

from ._core import (
    Account,
    AttitudeHistory,
    Body,
    Case,
    Difference,
    Ephemeris,
    FreeMotion,
    Inertia,
    Instant,
    MassProperties,
    Mesh,
    Motion,
    Orbit,
    Plan,
    PlannedEffect,
    Scene,
    Segment,
    SpinSolution,
    State,
    Torque,
    TorquedMotion,
    Uncertainty,
    compare,
    endings,
    energy_at,
    euler_angles,
    euler_rates,
    frame_rotation,
    input_formats,
    leap_seconds,
    methods,
    omega_from_euler_rates,
    q_frame_from_momentum,
    q_from_euler,
    read,
    read_case,
    read_mesh,
    set_leap_seconds,
    solve_periods,
    write,
)
from ._core import version as __version__
from ._errors import ComputationError, Error, FileError, InputError
from ._program import program

if TYPE_CHECKING:
    from .fitting import Fit, fit
    from .sampling import sample, sample_rows

__all__ = [
    "Account",
    "AttitudeHistory",
    "Body",
    "Case",
    "ComputationError",
    "Difference",
    "Ephemeris",
    "Error",
    "FileError",
    "Fit",
    "FreeMotion",
    "Inertia",
    "InputError",
    "Instant",
    "MassProperties",
    "Mesh",
    "Motion",
    "Orbit",
    "Plan",
    "PlannedEffect",
    "Scene",
    "Segment",
    "SpinSolution",
    "State",
    "Torque",
    "TorquedMotion",
    "Uncertainty",
    "__version__",
    "compare",
    "endings",
    "energy_at",
    "euler_angles",
    "euler_rates",
    "fit",
    "frame_rotation",
    "input_formats",
    "leap_seconds",
    "methods",
    "omega_from_euler_rates",
    "program",
    "q_frame_from_momentum",
    "q_from_euler",
    "read",
    "read_case",
    "read_mesh",
    "sample",
    "sample_rows",
    "set_leap_seconds",
    "solve_periods",
    "write",
]

_MODULE_OF = {"Fit": "fitting", "fit": "fitting", "sample": "sampling", "sample_rows": "sampling"}


def __getattr__(name: str) -> Any:
    """What most programs do not need is imported when it is asked for."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    from importlib import import_module

    found = getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

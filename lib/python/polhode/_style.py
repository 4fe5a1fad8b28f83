"""The light and the dark look of figures."""

import io
from dataclasses import dataclass

import matplotlib.patheffects as effects
from matplotlib.figure import Figure

from ._errors import InputError


@dataclass(frozen=True)
class Style:
    """Colours, by what they are for."""

    paper: str  # behind everything
    ink: str  # axes, titles
    pencil: str  # small words
    grid: str
    faint: str  # curves that are only for comparison
    sphere: tuple[float, float, float]
    blue: str  # rotation about the axis of least inertia: case (i)
    red: str  # about the axis of greatest inertia: case (ii)
    green: str  # the separatrix: case (iii)
    tint: float  # how light a surface of a colour is
    map_ends: tuple[float, float]  # the part of matplotlib's cividis that is told from the paper

    @property
    def halo(self) -> list[effects.AbstractPathEffect]:
        """Of words that may stand on curves."""
        return [effects.withStroke(linewidth=3, foreground=self.paper)]


STYLES = {
    "light": Style(
        paper="#ffffff", ink="#1b1f24", pencil="#555a60", grid="#c9ccd0", faint="#8a8f94", sphere=(0.93, 0.92, 0.89),
        blue="#0b5fa5", red="#c2452d", green="#3f8f3a", tint=0.55, map_ends=(0.0, 0.88),
    ),
    "dark": Style(
        paper="#14171b", ink="#eceff2", pencil="#a8afb7", grid="#3a4048", faint="#7f8790", sphere=(0.46, 0.47, 0.50),
        blue="#58a8ee", red="#f2795f", green="#72c46c", tint=0.12, map_ends=(0.25, 1.0),
    ),
}  # fmt: skip


def style_named(name: str) -> Style:
    if name not in STYLES:
        raise InputError(f"the style is '{name}'; {' or '.join(STYLES)} is wanted")
    return STYLES[name]


class Shown(Figure):
    """A figure that a notebook shows, whether or not pyplot has been imported."""

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png")
        return out.getvalue()

"""A spin state and ratios of inertia from measurements: `polhode.fit`, and the subcommand `polhode fit`."""

from .api import fit
from .observations import Rows, read_observations
from .result import Fit

__all__ = ["Fit", "Rows", "fit", "main", "read_observations"]


def main(arguments):
    """The subcommand."""
    from .command import main as run

    run(arguments)

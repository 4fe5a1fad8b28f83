"""polhode fit."""

from __future__ import annotations

import sys
from pathlib import Path

from .. import _files
from .._errors import InputError
from .api import fit


def semi_axes(text):
    """'4.60 2.40 1.92 km' or '4.60 2.40 1.92'."""
    words = text.split()
    try:
        numbers = [float(word) for word in words[:3]]
    except ValueError:
        numbers = []
    if len(numbers) != 3 or len(words) > 4:
        raise InputError(f"--shape: found '{text}'; three semi-axes along x, y, z are wanted, and perhaps a unit")
    return numbers


def names(text):
    return [name.strip() for name in text.split(",") if name.strip()]


def arguments_of(arguments):
    parser = _files.Parser(prog="polhode fit", description="A spin state and ratios of inertia from measurements")
    add = parser.add_argument
    add("body", metavar="BODY|SCENE", help="body file or scene; a body file with a name only, or a name: nothing is known")
    add("observations", metavar="OBSERVATIONS", nargs="+", help="tables of attitudes, rates, directions or magnitudes; attitude histories")
    add("-o", "--output", required=True, metavar="FITTED.toml", help="body file; further solutions beside it, with their rank in the name")
    add("--residuals", metavar="TABLE", help="CSV of the residuals")
    add("--picture", metavar="FILE", help="picture of the residuals: .png, .pdf or .svg")
    add("--free", type=names, metavar="NAMES", help="these numbers are free and no others; +NAME: also this one")
    add("--fixed", type=names, metavar="NAMES", help="these numbers are held")
    add("--robust", action="store_true", help="leave out what does not belong, and name it")
    add("--sigma", metavar="ANGLE", help="of attitudes and directions that have none: '2 deg'")
    add("--sigma-rates", metavar="RATE", help="of rates that have none: '1 deg/day'; without it these are not fitted")
    add("--sigma-magnitudes", type=_files.positive, metavar="MAG", help="added to the sigmas of magnitudes, in squares")
    add("--shape", type=semi_axes, metavar="'A B C'", help="semi-axes of the ellipsoid along x, y, z, for magnitudes")
    add("--products", action="store_true", help="products of inertia are free, too")
    add("--turns", type=int, metavar="N", help="turns more or fewer that are tried over gaps (default: 3, of scenes 0)")
    add("--within", type=_files.positive, default=25.0, metavar="CHI2", help="other solutions up to so much above the best chi-squared (default: 25)")
    add("--max-rate", metavar="RATE", help="from nothing: the fastest rate that is looked for, '30 deg/day'")
    return parser.parse_args(arguments)


def shown(done, of):
    end = "\n" if done >= of else ""
    print(f"\rpolhode: {done} of {of}  ", end=end, file=sys.stderr, flush=True)


def main(arguments):
    options = arguments_of(arguments)
    out = Path(options.output)
    if options.picture:
        from ..plot import picture_format

        format = picture_format(Path(options.picture))
    found = fit(
        options.body,
        list(options.observations),
        free=options.free,
        fixed=options.fixed,
        robust=options.robust,
        sigma=options.sigma,
        sigma_rates=options.sigma_rates,
        sigma_magnitudes=options.sigma_magnitudes,
        shape=options.shape,
        products=options.products,
        turns=options.turns,
        within=options.within,
        max_rate=options.max_rate,
        progress=shown if sys.stderr.isatty() else None,
    )
    found.write(out)
    for other in found.solutions[1:]:
        other.write(out.with_name(f"{out.stem}-{other.rank}{out.suffix}"))
    if options.residuals:
        found.write_residuals(options.residuals)
    if options.picture:
        with _files.whole_file(options.picture) as file:
            found.figure().savefig(file, format=format)
    print(found.summary())

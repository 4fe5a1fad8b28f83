"""What the subcommands in Python share: attitude ephemerides in, files out, ends in one line."""

import argparse
import os
import signal
import stat
import sys
import tempfile
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ._errors import ComputationError, FileError, InputError


def end(status, message):
    line = " ".join(str(message).split())
    print(f"polhode: {line}", file=sys.stderr)
    sys.exit(status)


def run(main):
    """Calls main(). What goes wrong ends in one line on standard error and the program's status."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:  # so that what is half written is removed
            signal.signal(number, lambda number, _: sys.exit(128 + number))
    try:
        main()
        sys.stdout.flush()
    except InputError as error:
        end(2, error)
    except FileError as error:
        end(3, error)
    except ComputationError as error:
        end(1, error)
    except ModuleNotFoundError as error:
        end(1, f"this Python has no {error.name}: pip install 'polhode[fit,plot,spice]' brings it")
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what standard output did not take is not tried again
        end(3, f"{error.filename or 'standard output'}: {error.strerror or error}")
    except MemoryError:
        end(1, "there is not enough memory for what is asked")
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise InputError(f"{message}; --help says more")


def positive(text):
    """An argument that is a positive number."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number")
    return value


def duration_s(text):
    """An argument that is a positive duration, in s or with unit: "90", "10 min"."""
    number, _, unit = text.strip().partition(" ")
    units_s = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
    if unit.strip() not in units_s:
        raise argparse.ArgumentTypeError(f"'{text}' is no duration; allowed units are s, min, h, d")
    return positive(number) * units_s[unit.strip()]


# --- Files out --------------------------------------------------------------------------------------------------------


@contextmanager
def whole_file(path):
    """A binary file to write, which takes the place of `path` when all is written: it appears whole or not at all. A
    link is followed, what is there keeps its mode; a device or a pipe is written to as it is."""
    path = Path(path)
    if path.is_dir():
        raise FileError(f"{path} is a folder; a file is wanted")
    if path.exists() and not path.is_file():
        with reported(path), open(path, "wb") as file:
            yield file
        return
    path = Path(os.path.realpath(path))
    if not path.parent.is_dir():
        raise FileError(f"there is no folder {path.parent}")
    with reported(path):
        if path.exists():
            if not os.access(path, os.W_OK):
                raise FileError(f"{path} must not be written to")
            mode = stat.S_IMODE(path.stat().st_mode)
        else:
            mask = os.umask(0)
            os.umask(mask)
            mode = 0o666 & ~mask
        handle, hidden = tempfile.mkstemp(prefix=".polhode-", dir=path.parent)
        try:
            with open(handle, "wb") as file:
                yield file
            os.chmod(hidden, mode)
            os.replace(hidden, path)
        except BaseException:
            Path(hidden).unlink(missing_ok=True)
            raise


@contextmanager
def reported(path):
    """Errors of the system while `path` is written, under its name."""
    try:
        yield
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from error


def made_folder(path):
    """The folder, made if it is not there."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileError(f"{path} is not a folder") from None
    except OSError as error:
        raise FileError(f"the folder {path} cannot be made: {error.strerror}") from None
    return path


# --- Attitude ephemerides in ------------------------------------------------------------------------------------------

TIME_SCALES = ("TDB", "TT", "TAI", "UTC")


@dataclass
class Ephemeris:
    """The rows of a FITS file that `polhode propagate` wrote."""

    path: str
    header: Any  # of the table: like a dict
    time: Any  # astropy Time
    q: Any  # n x 4, scalar first, v_inertial = q v_body q*
    omega_body: Any  # n x 3, rad/s

    def keyword(self, name):
        if name not in self.header:
            raise InputError(f"{self.path} has no {name}; FITS that polhode propagate made of a body has it")
        return self.header[name]

    def number(self, name):
        value = self.keyword(name)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < float("inf"):
            raise InputError(f"{self.path}: {name} is {value!r}, not a number")
        return float(value)

    def text(self, name):
        return str(self.keyword(name))


def is_fits(path):
    """Whether a file is FITS, plain or packed by gzip: by its first bytes."""
    import gzip

    if not Path(path).is_file():  # it will be read more than once
        raise FileError(f"there is no file {path}" if not Path(path).exists() else f"{path} is not a file")
    with open(path, "rb") as file:
        head = file.read(6)
    if head[:2] == b"\x1f\x8b":
        try:
            with gzip.open(path) as file:
                head = file.read(6)
        except (OSError, EOFError, ValueError) as error:
            raise InputError(f"{path} cannot be unpacked: {error}") from None
    return head == b"SIMPLE"


def read_ephemeris(path):
    """Throws InputError where a column or keyword is missing, of another shape, or not finite, where the file is not
    whole, and where its time scale is not one that astropy reads as the program means it."""
    import numpy as np
    from astropy.io import fits
    from astropy.table import Table
    from astropy.time import Time

    if not is_fits(path):
        raise InputError(f"{path} is not FITS; write it by polhode propagate FILE -o OUT.fits")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            with open(path, "rb") as file, fits.open(file, memmap=False, checksum=True) as hdus:
                hdu = hdus["ATTITUDE"]
                header = hdu.header.copy()
                table = Table.read(hdu, astropy_native=True)
        except OSError as error:
            raise (FileError if error.errno else InputError)(f"{path} cannot be read: {error.strerror or error}") from None
        except KeyError:
            raise InputError(f"{path} has no table ATTITUDE; FITS that polhode propagate wrote has it") from None
        except Exception as error:  # astropy has many for files that are cut short or not what they seem
            raise InputError(f"{path} cannot be read: {error}") from None
    for warning in said:
        if any(word in str(warning.message) for word in ("truncated", "Checksum", "Datasum")):
            raise InputError(f"{path} is damaged: {warning.message}")

    def column(name, width):
        if name not in table.colnames:
            raise InputError(f"{path}: table ATTITUDE has no column {name}")
        try:
            values = np.asarray(table[name], dtype=float)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != (len(table), width) or not np.isfinite(values).all():
            raise InputError(f"{path}: column {name} is not {width} finite numbers in every row")
        return values

    if len(table) == 0:
        raise InputError(f"{path}: table ATTITUDE has no rows")
    ephemeris = Ephemeris(str(path), header, table["TIME"] if "TIME" in table.colnames else None, None, None)
    scale = ephemeris.text("TIMESYS")
    if scale not in TIME_SCALES:
        raise InputError(f"{path}: TIMESYS is {scale}, which readers take differently; allowed: {', '.join(TIME_SCALES)}")
    ephemeris.number("MJDREF")
    if not isinstance(ephemeris.time, Time):
        raise InputError(f"{path}: table ATTITUDE has no column TIME in seconds or days")
    if len(table) > 1 and not (np.diff(ephemeris.time.jd1) + np.diff(ephemeris.time.jd2) > 0).all():
        raise InputError(f"{path}: TIME does not ascend from row to row")
    if ephemeris.text("QORDER") != "XYZS" or ephemeris.text("QDIR") != "A2B":
        raise InputError(f"{path}: QORDER, QDIR are not XYZS, A2B")
    q = column("QPARAM", 4)[:, [3, 0, 1, 2]]
    length = np.linalg.norm(q, axis=1, keepdims=True)
    if not (abs(length - 1) < 1e-3).all():
        raise InputError(f"{path}: column QPARAM is not quaternions of length 1")
    ephemeris.q, ephemeris.omega_body = q, column("OMEGA", 3)
    return ephemeris

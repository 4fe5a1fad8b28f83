"""Clones drawn from the uncertainties of a body or scene, on this machine or on the workers of a Dask cluster."""

from __future__ import annotations

import csv
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ._errors import InputError
from ._files import whole_file
from ._program import completed


def _part(options: Sequence[str], part: int, parts: int, threads: int) -> bytes:
    """The statistics of a part of the clones, as the program writes them. A function of its arguments alone."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "sample.part")
        completed("sample", *options, "--part", f"{part}/{parts}", "--threads", threads, "-o", path)
        return path.read_bytes()


def _columns(path: Path) -> dict[str, np.ndarray]:
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    names, cells = rows[0], np.array(rows[1:], dtype=object)
    return {
        name: cells[:, k].astype(str) if name.startswith("date_") else cells[:, k].astype(float)
        for k, name in enumerate(names)
    }


def _options(
    path: str | os.PathLike[str],
    count: int,
    seed: int,
    times: str | Sequence[str],
    frame: str | None,
    scale: str,
    uniform: Mapping[str, float] | None,
) -> list[str]:
    source = Path(path).resolve()
    wanted = times if isinstance(times, str) else ",".join(str(time) for time in times)
    options = [str(source), "--count", str(count), "--seed", str(seed), "--times", wanted, "--scale", scale]
    if frame is not None:
        options += ["--frame", frame]
    for name, width in (uniform or {}).items():
        options += ["--uniform", f"{name}={width!r}"]
    return options


def sample(
    path: str | os.PathLike[str],
    *,
    count: int,
    seed: int,
    times: str | Sequence[str],
    frame: str | None = None,
    scale: str = "TDB",
    uniform: Mapping[str, float] | None = None,
    parts: int | None = None,
    threads: int = 0,
    client: Any = None,
    output: str | os.PathLike[str] | None = None,
) -> dict[str, np.ndarray]:
    """Statistics of `count` clones of the body or scene in a file, drawn from its uncertainties: a column each, as
    `polhode sample` writes them, one row for each of the `times` (dates with their scale). Clone n depends on the seed and
    n alone. `uniform` names numbers that are not known at all, and the width about their values. `client`, of
    dask.distributed, has the parts done by its workers, which must see the file under its path; what a lost worker had is
    done again by another, and the result is the same bits. `output` is written as well: FITS, CSV or ECSV by its ending.
    Raises InputError, FileError, ComputationError."""
    options = _options(path, count, seed, times, frame, scale, uniform)
    if parts is None:
        parts = 1 if client is None else max(8, 4 * len(client.scheduler_info()["workers"]))
    if client is None:
        made = [_part(options, part, parts, threads) for part in range(1, parts + 1)]
    else:
        futures = [client.submit(_part, options, part, parts, 1, pure=False) for part in range(1, parts + 1)]
        made = client.gather(futures)
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for number, content in enumerate(made):
            files.append(Path(folder, f"{number}.part"))
            files[-1].write_bytes(content)
        table = Path(folder, "sample.csv")
        completed("sample", "--join", *files, "-o", table)
        if output is not None:
            completed("sample", "--join", *files, "-o", Path(output).resolve())
        return _columns(table)


def sample_rows(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    count: int,
    seed: int,
    times: str | Sequence[str],
    frame: str | None = None,
    scale: str = "TDB",
    uniform: Mapping[str, float] | None = None,
    threads: int = 0,
) -> None:
    """Writes every clone of `sample` at each of the times as a row, as `polhode sample --rows` does: FITS, CSV, ECSV, or by
    pyarrow Parquet, by the output's ending. Memory does not depend on the count; for Parquet the rows stand in a temporary
    file first. Raises InputError, FileError, ComputationError."""
    target = Path(output).resolve()
    options = [*_options(path, count, seed, times, frame, scale, uniform), "--rows", "--threads", threads]
    if target.suffix != ".parquet":
        completed("sample", *options, "-o", target)
        return
    try:
        import pyarrow as arrow
        from pyarrow import csv as arrow_csv
        from pyarrow import parquet
    except ImportError as missing:
        raise InputError("Parquet is written by pyarrow, which is not installed; .fits, .csv and .ecsv need nothing") from missing
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder, "rows.csv")
        completed("sample", *options, "-o", rows)
        comments = []
        with open(rows, encoding="utf-8") as file:
            for line in file:
                if not line.startswith("#"):
                    break
                comments.append(line[1:].strip())
        names = line.strip().split(",")
        kinds = {"clone": arrow.int64(), f"date_{scale.lower()}": arrow.string(), "mode": arrow.string()}
        types = {name: kinds.get(name, arrow.float64()) for name in names}
        schema = arrow.schema(list(types.items()), metadata={"polhode": "\n".join(comments)})
        read = arrow_csv.ReadOptions(skip_rows=len(comments))
        convert = arrow_csv.ConvertOptions(column_types=types, null_values=[], strings_can_be_null=False)
        with whole_file(target) as file, arrow_csv.open_csv(rows, read, convert_options=convert) as batches:
            with parquet.ParquetWriter(file, schema) as writer:
                for batch in batches:
                    writer.write_batch(batch.cast(schema))

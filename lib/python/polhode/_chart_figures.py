"""What the figures of all tables of `polhode chart` share."""

from matplotlib.figure import Figure

from . import _files

INK = "#1b1f24"
FAINT = "#8a9199"


def subplots(rows=1, columns=1, figsize=None, layout=None, **options):
    figure = Figure(figsize=figsize, layout=layout)
    return figure, figure.subplots(rows, columns, **options)


def save(figure, folder, name):
    for ending in ("svg", "png"):
        path = _files.made_folder(folder) / f"{name}.{ending}"
        with _files.whole_file(path) as file:
            figure.savefig(file, format=ending, dpi=170, facecolor="white")
        print(path)

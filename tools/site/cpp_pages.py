"""Pages of the C++ API for Breathe, one for each folder of public headers: cpp_pages.py SOURCE_FOLDER DOXYGEN_XML"""

import re
import sys
from itertools import groupby
from pathlib import Path

LIB = Path(__file__).resolve().parents[2] / "lib"
folder, xml = map(Path, sys.argv[1:])


def with_its_folder(entry):
    """Breathe finds a file by the name in Doxygen's index, which has no folder."""
    location = re.search(r'<location file="([^"]+)"/>', (xml / f"{entry[1]}.xml").read_text())[1]
    return f'<compound refid="{entry[1]}" kind="file"><name>{location}</name>'


index = xml / "index.xml"
index.write_text(re.sub(r'<compound refid="(\w+)" kind="file"><name>[^<]*</name>', with_its_folder, index.read_text()))

patterns = (LIB / "public_headers.txt").read_text().split()
headers = sorted({path.relative_to(LIB).as_posix() for pattern in patterns for path in LIB.glob(pattern)})
contents = []
(folder / "cpp").mkdir(exist_ok=True)
for name, group in groupby(headers, key=lambda header: header.split("/")[1]):
    sections = [f"## `{header}`\n\n```{{doxygenfile}} {header}\n```\n" for header in group]
    (folder / "cpp" / f"{name}.md").write_text("\n".join([f"# {name}\n", *sections]))
    contents.append(f"cpp/{name}")
(folder / "cpp-api.md").write_text(
    "# C++ API\n\n[The library's headers](tools/manual/library.md) introduces the library; these pages list what its public "
    "headers declare, by folder.\n\n```{toctree}\n" + "\n".join(contents) + "\n```\n"
)

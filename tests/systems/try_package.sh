#!/usr/bin/env bash
# Whether an installed package does what the README says: try_package.sh ENVIRONMENT SOURCE_TREE
#
# The README's example in Python, the time that `import polhode` adds to that of numpy (40 ms at most), and the program.
set -euo pipefail
environment=$(cd "$1" && pwd) tree=$(cd "$2" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
ln -s "$tree/data" data
python=$environment/bin/python

sed -n '/^```python$/,/^```$/p' "$tree/README.md" | sed '/^```/d' >example.py
$python example.py >printed
sed -n 's/^print(.*)  # //p' example.py | diff - printed
test -s toutatis.fits

$python - <<'PYTHON'
import subprocess, sys

def seconds(code):
    code = f"import time; t = time.perf_counter(); {code}; print(time.perf_counter() - t)"
    return min(float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout) for _ in range(9))

added = seconds("import polhode") - seconds("import numpy")
print(f"import polhode adds {1e3 * added:.0f} ms to numpy's")
assert added < 0.04
PYTHON

"$environment/bin/polhode" info data/bodies/toutatis.toml | head -n 3
"$environment/bin/polhode" propagate data/bodies/toutatis.toml --stop "+1 d" --step "1 h" -o a.fits
"$environment/bin/polhode" plan data/scenes/envisat-month.toml >/dev/null
echo "the package works in $environment"

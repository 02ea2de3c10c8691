#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Install the Python package on top of an environment that has Blender's module, and use it:
#   scripts/check_package.sh PYTHON FOLDER
set -eu
python=$1 folder=$2
root=$(cd "$(dirname "$0")/.." && pwd)
# pip builds in the folder that it installs from, so it gets a copy.
mkdir -p "$folder/source"
tar -C "$root" -cf - __init__.py blender_manifest.toml pyproject.toml setup.py README.md LICENSE \
    parts.py angen_addon operators panels residents sensor_logic studies | tar -C "$folder/source" -xf -
"$python" -m pip install -q --disable-pip-version-check --no-deps --target "$folder" "$folder/source"
cd "$folder"
export PYTHONPATH="$folder"
bin/angen simulate "$root/sample_blends/light_control.blend" --quiet --events events.csv
bin/angen convert events.csv --format mcap --out events.mcap --start 2026-03-02
"$python" - "$root/sample_blends/light_control.blend" <<'END'
import sys
from pathlib import Path

import angen_sensors

assert Path(angen_sensors.__file__).parent.parent == Path.cwd(), angen_sensors.__file__
with angen_sensors.open(sys.argv[1]) as home:
    home.simulate().write("again.csv")
END
cmp events.csv again.csv
cat >study.toml <<END
home = "$root/sample_blends/light_control.blend"
frames = [1, 24]
END
bin/angen study run study.toml --out study --jobs 1
test -s study/results.csv
# The page needs matplotlib, which an environment for tests may lack.
! "$python" -c "import matplotlib" 2>/dev/null || bin/angen study report study
echo "The installed package and its command write the same events."

#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Check the types:   scripts/check_types.sh PYTHON
# The modules import each other as parts of one package, as in Blender. mypy sees that package under
# the name angen_sensors, whatever the checkout's folder is called.
set -eu
mkdir -p .types
ln -sfn .. .types/angen_sensors
set -- "$1" -m mypy -m angen_sensors
for package in sensor_logic angen_addon operators panels residents studies parts; do
    set -- "$@" -p "angen_sensors.$package"
done
for script in scripts/*.py; do set -- "$@" -m "$(basename "$script" .py)"; done
MYPYPATH=.types:scripts exec "$@"

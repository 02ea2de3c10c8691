#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Checks the types:   scripts/check_types.sh PYTHON
# The modules import each other as parts of one package, as they do inside Blender; mypy gets to see
# that package, whatever the checkout's folder is called.
set -eu
mkdir -p .types
ln -sfn .. .types/angen_sensors
set -- "$1" -m mypy -m angen_sensors
for package in sensor_logic angen_addon operators panels residents studies parts; do
    set -- "$@" -p "angen_sensors.$package"
done
for script in scripts/*.py; do set -- "$@" -m "$(basename "$script" .py)"; done
MYPYPATH=.types:scripts exec "$@"

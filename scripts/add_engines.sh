#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Adds the engines that the benchmarks compare with to an environment of dev.py, once:
#   scripts/add_engines.sh DIR
# An engine that cannot be installed here is named; the benchmarks leave it out, and say so too.
set -eu
requirements=$(dirname "$0")/requirements-bench.txt
venv=$1
stamp=$(cksum <"$requirements")
[ "$(cat "$venv/engines" 2>/dev/null)" != "$stamp" ] || exit 0

# Keep numpy: Blender's module needs the version that it was installed with.
"$venv/bin/python" -c 'import numpy; print("numpy==" + numpy.__version__)' >"$venv/numpy.txt"
complete=true
for engine in embreex matplotlib mujoco pyradiance; do
    "$venv/bin/python" -m pip install -qq --disable-pip-version-check --retries 1 \
        -c "$requirements" -c "$venv/numpy.txt" "$engine" && continue
    echo "Could not install $engine: the benchmarks leave it out; pip's message is above." >&2
    complete=false
done
if $complete; then
    echo "$stamp" >"$venv/engines"
fi

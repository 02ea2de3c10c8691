#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Print the path of a Python of one of the given versions that can make virtual environments:
#   scripts/find_python.sh 3.13 3.11
# It looks on PATH, then among pyenv's versions. If the variable PYTHON names a command, it tries
# only that. Exit status 1: none was found; 2: one was found, but it cannot make virtual environments
# (the script prints what to install).
set -eu

if [ -n "${PYTHON:-}" ]; then
    candidates=$PYTHON
else
    candidates=
    for version in "$@"; do candidates="$candidates python$version"; done
    candidates="$candidates python3 python"
    for version in "$@"; do
        candidates="$candidates ${PYENV_ROOT:-$HOME/.pyenv}/versions/$version.*/bin/python"
    done
fi

incomplete=
for python in $candidates; do
    # A pyenv shim of a version that is not active exists and fails, so run the command.
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
    case " $* " in *" $version "*) ;; *) continue ;; esac
    if "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        "$python" -c 'import sys; print(sys.executable)'
        exit 0
    fi
    incomplete=${incomplete:-$version}
done

[ -n "$incomplete" ] || exit 1
echo "Python $incomplete is here, but not what it makes virtual environments with; on Debian and Ubuntu:
    apt install python$incomplete-venv" >&2
exit 2

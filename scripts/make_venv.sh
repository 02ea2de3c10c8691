#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Make a virtual environment, unless it exists and is complete:
#   scripts/make_venv.sh DIR test     Blender as a Python module, and what the tests need
#   scripts/make_venv.sh DIR lint     the linters (no Blender)
#   scripts/make_venv.sh DIR docs     the site of the docs (no Blender)
#   scripts/make_venv.sh DIR readers  other programs that read our files (no Blender)
# PYTHON=COMMAND chooses the interpreter, BPY=4.2 the version of Blender. Where no Python fits any
# Blender module but a Blender program is on PATH, "test" makes an environment without the module.
set -eu
here=$(dirname "$0")
venv=$1 purpose=$2
requirements=$here/requirements-$purpose.txt
say() { echo "$*" >&2; }
version() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || :; }
runs() { "$1/bin/python" -c "" 2>/dev/null; }
ready() { [ "$(cat "$venv/ready" 2>/dev/null)" = "$1" ] && runs "$venv"; }
fits() { [ -z "${PYTHON:-}" ] || [ "$(version "$PYTHON")" = "$(version "$venv/bin/python")" ]; }

no_python() {
    say "No suitable Python here${PYTHON:+ (PYTHON=$PYTHON)}: it must be $(echo "$versions" | sed 's/ / or /g')."
    [ "$purpose" != test ] || say "\
Blender's Python module exists for Python 3.13 (Blender 5.1, 5.2) and 3.11 (Blender 4.2 to 5.0).
Any one of these helps:
  - Debian 13, Ubuntu 25.04:   apt install python3.13-venv
  - Debian 12, Ubuntu 22.04:   apt install python3.11-venv
  - elsewhere:                 pyenv install 3.13, or: uv python install 3.13
  - one that is not on PATH:   make ... PYTHON=/path/to/python3.13
  - Blender 4.2 or newer as the command 'blender', beside Python 3.12 or 3.14 and its venv module"
    exit 1
}

case $purpose,${BPY:-} in
    lint,* | docs,*) versions="3.13 3.12 3.11 3.14" ;;
    # pyadlml reads CASAS only with pandas before 2.2.
    readers,*) versions="3.11 3.12" ;;
    test,4.* | test,5.0*) versions=3.11 ;;
    test,?*) versions=3.13 ;;
    test,) versions="3.13 3.11" ;;
esac

# The recipe is stored in the environment: if it changes, the environment is made again.
stamp="$purpose ${BPY:-} $(cat "$requirements" "$0" | cksum)"
if ready "$stamp" && fits; then
    exit 0
fi

bpy=
status=0
# shellcheck disable=SC2086  # a list of versions
python=$("$here/find_python.sh" $versions) || status=$?
if [ $status = 0 ]; then
    case $purpose,${BPY:-},$(version "$python") in
        lint,* | docs,* | readers,*) ;;
        *,?*,*) bpy=$BPY ;;
        *,3.11) bpy=4.5 ;;
        *,3.13) bpy=5.2 ;;
    esac
elif [ $status = 2 ]; then
    exit 1
elif [ "$purpose" = test ] && [ -z "${BPY:-}${PYTHON:-}" ] && command -v blender >/dev/null; then
    python=$("$here/find_python.sh" 3.12 3.14) || { [ $? = 2 ] && exit 1; no_python; }
    stamp="$stamp without bpy"
    ready "$stamp" && exit 0
    say "No Python 3.13 or 3.11 here: $(command -v blender) will be used instead of Blender's module."
else
    no_python
fi

# Blender's module with a numpy that it can use; exact versions for those that CI tests.
case $purpose,$bpy in
    test,4.2) packages="bpy==4.2.23 numpy==1.24.4" ;;
    test,4.5) packages="bpy==4.5.15 numpy==1.26.4" ;;
    test,5.2) packages="bpy==5.2.3 numpy==2.5.5" ;;
    test,) packages=numpy ;;
    test,*) packages="bpy==$bpy.*" ;;
    *) packages= ;;
esac

# Two stamps, each written last, so that half an environment never counts as complete: "installed",
# and "ready" once Blender's module starts, which may first need system libraries.
installed="$stamp, Python $(version "$python")"
if [ "$(cat "$venv/installed" 2>/dev/null)" != "$installed" ] || ! runs "$venv"; then
    say "Making $venv for $python${bpy:+ with Blender $bpy as a module (350 MB to fetch, once)} ..."
    rm -rf "$venv"
    "$python" -m venv "$venv"
    # shellcheck disable=SC2086  # a list of packages
    "$venv/bin/python" -m pip install -qq --disable-pip-version-check -r "$requirements" $packages || {
        say "Could not install what $requirements lists${packages:+ and $packages}; pip's message is above."
        exit 1
    }
    echo "$installed" >"$venv/installed"
fi
if [ -n "$bpy" ] && ! "$venv/bin/python" -c 'import bpy'; then
    say "Blender's module does not start here. On Debian and Ubuntu it needs:
    apt install libgl1 libgomp1 libice6 libsm6 libx11-6 libxfixes3 libxi6 libxkbcommon0 libxrender1 libxxf86vm1"
    exit 1
fi
echo "$stamp" >"$venv/ready"

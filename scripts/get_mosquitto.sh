#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Put Debian's mosquitto, an MQTT broker, into a folder, without root:
#   scripts/get_mosquitto.sh build/mosquitto
# Afterwards the folder has bin/mosquitto, bin/mosquitto_sub, bin/mosquitto_pub and
# bin/mosquitto_passwd. Installed programs are linked. Exit status 1: no way to get them here.
set -eu
folder=$1
programs="mosquitto mosquitto_sub mosquitto_pub mosquitto_passwd"
[ ! -x "$folder/bin/mosquitto_sub" ] || exit 0
PATH=$PATH:/usr/sbin
rm -rf "$folder"
mkdir -p "$folder/bin" "$folder/packages"

if command -v mosquitto && command -v mosquitto_sub && command -v mosquitto_passwd; then
    for program in $programs; do ln -s "$(command -v "$program")" "$folder/bin/"; done
    exit 0
fi >/dev/null
if ! command -v apt-get >/dev/null || ! command -v dpkg-deb >/dev/null; then
    echo "mosquitto is not installed, and this is no Debian or Ubuntu to fetch it from" >&2
    exit 1
fi
# The programs, and the libraries that a minimal system lacks.
(cd "$folder/packages" && apt-get -qq download mosquitto mosquitto-clients libmosquitto1 libcjson1 \
    libdlt2 libwrap0 libcap2) || {
    echo "mosquitto cannot be fetched here: apt install mosquitto mosquitto-clients" >&2
    exit 1
}
for package in "$folder"/packages/*.deb; do dpkg-deb -x "$package" "$folder/root"; done
root=$(cd "$folder/root" && pwd)
for program in $programs; do
    found=$(find "$root/usr" -path "*bin/$program")
    libraries=$(find "$root" -name 'lib*.so*' -exec dirname {} + | sort -u | paste -sd:)
    printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s "$@"\n' "$libraries" "$found" >"$folder/bin/$program"
    chmod +x "$folder/bin/$program"
done
"$folder/bin/mosquitto" -h | head -1

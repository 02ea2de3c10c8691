# SPDX-License-Identifier: GPL-3.0-or-later
"""The file of a sensor's samples on one day, and gzip files without a date."""

import gzip
from datetime import date

from angen_sensors.residents.days.samples import samples_csv
from angen_sensors.sensor_logic.logs.files import gzipped, write_files
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.tracks import Track

MIDNIGHT = 86_520.0


def track(times):
    found = Track("array", "THERMAL_ARRAY")
    for k, time in enumerate(times):
        fields = {"max_c": 20.0 + k, "occupied": k > 1, "warm_pixels": k, "mean_c": 20.0}
        found.append(
            0.0, MIDNIGHT + time, Reading(k > 1, 0.0, {**fields, "frame_c": f"{k}.00;1.00"})
        )
    return found


def test_a_day_has_the_updates_from_midnight_to_midnight():
    text = "".join(
        samples_csv(track([-0.1, 0.0, 0.1, 86_399.9, 86_400.0]), date(2026, 3, 2), MIDNIGHT)
    )
    assert text.split("\r\n") == [
        "time,max_c,occupied,warm_pixels,mean_c,frame_c",
        "2026-03-02T00:00:00.000,21,0,1,20,1.00;1.00",
        "2026-03-02T00:00:00.100,22,1,2,20,2.00;1.00",
        "2026-03-02T23:59:59.900,23,1,3,20,3.00;1.00",
        "",
    ]


def test_a_day_without_updates_has_the_header():
    assert "".join(samples_csv(track([]), date(2026, 3, 2), MIDNIGHT)).startswith("time,max_c,")


def test_equal_texts_give_equal_gzip_files(tmp_path):
    texts = ["a,b\r\n", "1,å\r\n" * 10_000]
    one, other = tmp_path / "one.csv.gz", tmp_path / "other.csv.gz"
    write_files({one: gzipped(texts), other: gzipped(["".join(texts)])})
    assert gzip.decompress(one.read_bytes()).decode() == "".join(texts)
    assert one.read_bytes()[4:8] == b"\0\0\0\0", "no date"
    write_files({other: gzipped(texts)})
    assert one.read_bytes() == other.read_bytes()

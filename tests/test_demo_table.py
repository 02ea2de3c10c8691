# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of `make demo`."""

import demo_table
from demo_table import Report

# Units of what a sensor publishes, as `list --json` tells them.
PAD = {"pressed": "", "force_n": "N", "partners": "", "valid": ""}
LIGHT = {"luminance_percent": "%", "illuminance_lux": "lx", "lit": ""}
EVENT_LOG = '''\
time_s,frame,sensor,kind,field,value
0.000000,1,"pad, ""bed""",PRESSURE,force_n,0
0.000000,1,"pad, ""bed""",PRESSURE,pressed,0
0.000000,1,still,PIR,moved,0
0.100000,4,pir,PIR,moved,0
2.500000,61,pir,PIR,moved,1
3.000000,73,"pad, ""bed""",PRESSURE,force_n,700
3.000000,73,"pad, ""bed""",PRESSURE,pressed,1
4.000000,97,pir,PIR,moved,0
'''.splitlines(keepends=True)


def test_the_first_update_of_a_sensor_is_no_change() -> None:
    assert demo_table.change_times(EVENT_LOG) == {
        'pad, "bed"': [3.0, 3.0],
        "still": [],
        "pir": [2.5, 4.0],
    }


def test_the_share_of_time_active_counts_samples() -> None:
    samples = ["time_s,frame,moved\n", "0,1,0\n", "0.1,4,1\n", "0.2,7,1\n", "0.3,9,1\n"]
    assert demo_table.active_share(samples, "PIR") == 0.75
    assert demo_table.active_share(samples[:1], "PIR") == 0.0


def test_the_last_sample_tells_how_long_the_run_was() -> None:
    assert demo_table.last_time(["time_s,frame,moved\n", "0,1,0\n", "59.9,1438,1\n"]) == 59.9


def test_the_greatest_force_is_that_of_valid_samples() -> None:
    samples = ["time_s,frame,force_n,valid\n", "0,1,900,0\n", "1,25,-1.5,1\n", "2,49,686.74,1\n"]
    assert demo_table.greatest(samples, PAD) == "687 N"
    assert demo_table.greatest(samples[:2], PAD) == ""


def test_the_greatest_luminance_is_that_of_all_samples() -> None:
    samples = ["time_s,frame,luminance_percent,lit\n", "0,1,9.5,0\n", "1,25,31.26,1\n"]
    assert demo_table.greatest(samples, LIGHT) == "31.3 %"
    assert demo_table.greatest(samples[:1], LIGHT) == ""


def test_the_greatest_light_of_a_sensor_by_illuminance_is_in_lux() -> None:
    samples = ["time_s,frame,luminance_percent,illuminance_lux,lit\n", "0,1,,31.26,0\n"]
    assert demo_table.greatest([*samples, "1,25,,1445.2,1\n"], LIGHT) == "1445 lx"


def test_kinds_without_a_value_have_no_greatest() -> None:
    assert demo_table.greatest(["time_s,frame,moved\n", "0,1,1\n"], {"moved": ""}) == ""


def sensor(kind: str, room: str = "bedroom") -> dict[str, str]:
    return {"name": f"{kind} 1", "kind": kind, "room": room}


def test_a_row_has_what_the_sensor_reported() -> None:
    assert demo_table.row(sensor("OPTICAL_SWITCH"), Report([2.5, 3.0, 4.04], 0.5)) == (
        ("bedroom", "OPTICAL_SWITCH 1", "optical switch", "3", "2.5", "4.0", "50.0%", "")
    )


def test_a_pad_has_its_greatest_force() -> None:
    assert demo_table.row(sensor("PRESSURE"), Report([1.0], 0.5, "686.7 N"))[-1] == "686.7 N"


def test_a_sensor_that_never_changed_has_no_times() -> None:
    assert demo_table.row(sensor("PIR", room=""), Report([], 0.0)) == (
        ("-", "PIR 1", "pir", "0", "-", "-", "0.0%", "")
    )


def test_columns_are_aligned() -> None:
    rows = [
        demo_table.row(sensor("PIR"), Report([1.0, 12.0], 1.0)),
        demo_table.row(sensor("PRESSURE"), Report([1.0, 12.0], 0.25, "700.0 N")),
        demo_table.row(sensor("LIGHT"), Report([], 0.0, "9.5 %")),
    ]
    assert demo_table.table(rows).splitlines() == [
        "room     sensor      kind      events  first s  last s  active      max",
        "-----------------------------------------------------------------------",
        "bedroom  PIR 1       pir            2      1.0    12.0  100.0%",
        "bedroom  PRESSURE 1  pressure       2      1.0    12.0   25.0%  700.0 N",
        "bedroom  LIGHT 1     light          0        -       -    0.0%    9.5 %",
    ]

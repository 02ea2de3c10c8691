# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of `make demo`."""

import pytest

import demo_table
from demo_table import Report

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


def test_figures_of_logs_and_samples() -> None:
    # The first update of a sensor is no change.
    changes = {'pad, "bed"': [3.0, 3.0], "still": [], "pir": [2.5, 4.0]}
    assert demo_table.change_times(EVENT_LOG) == changes
    samples = ["time_s,frame,moved\n", "0,1,0\n", "0.1,4,1\n", "0.2,7,1\n", "0.3,9,1\n"]
    assert demo_table.active_share(samples, "PIR") == 0.75
    assert demo_table.active_share(samples[:1], "PIR") == 0.0
    assert demo_table.last_time(samples) == 0.3


@pytest.mark.parametrize(
    ("samples", "greatest"),
    [
        (["force_n,valid", "900,0", "-1.5,1", "686.74,1"], "687 N"),
        (["force_n,valid", "900,0"], ""),
        (["luminance_percent,illuminance_lux,lit", "9.5,,0", "31.26,,1"], "31.3 %"),
        (["luminance_percent,illuminance_lux,lit", ",31.26,0", ",1445.2,1"], "1445 lx"),
        (["moved", "1"], ""),
    ],
)
def test_the_greatest_value_is_that_of_valid_samples(samples, greatest) -> None:
    units = {"force_n": "N", "luminance_percent": "%", "illuminance_lux": "lx", "moved": ""}
    assert demo_table.greatest([f"{line}\n" for line in samples], units) == greatest


def test_columns_are_aligned() -> None:
    def row(kind, report, room="bedroom"):
        return demo_table.row({"name": f"{kind} 1", "kind": kind, "room": room}, report)

    rows = [
        row("OPTICAL_SWITCH", Report([1.0, 3.0, 12.04], 1.0)),
        row("PRESSURE", Report([1.0, 12.0], 0.25, "700.0 N")),
        row("LIGHT", Report([], 0.0, "9.5 %"), ""),
    ]
    assert demo_table.table(rows).splitlines() == [
        "room     sensor            kind            events  first s  last s  active      max",
        "-----------------------------------------------------------------------------------",
        "bedroom  OPTICAL_SWITCH 1  optical switch       3      1.0    12.0  100.0%",
        "bedroom  PRESSURE 1        pressure             2      1.0    12.0   25.0%  700.0 N",
        "-        LIGHT 1           light                0        -       -    0.0%    9.5 %",
    ]

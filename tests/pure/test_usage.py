# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line where its arguments are in the wrong place: told before Blender starts."""


def test_usage_is_told(angen) -> None:
    status, _, err = angen()
    assert status == 2 and "usage" in err
    status, _, err = angen("simulate", "--frames", "1:2")
    assert status == 2 and "usage" in err
    status, out, _ = angen("--help")
    assert status == 0 and "simulate" in out and "study" in out


def test_a_wrong_verb_gets_the_nearest_one(angen) -> None:
    for arguments in (["simul"], ["simul", "home.blend"]):
        status, _, err = angen(*arguments)
        assert status == 2 and err.count("\n") == 1
        assert err.endswith("did you mean simulate?\n")

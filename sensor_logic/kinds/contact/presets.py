# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial door contacts, each with the magnet that its maker specifies."""

from __future__ import annotations

from ...kind import Preset

REED_RELAYS = (
    "Reed Relays and Electronics India, actuation distances of the {} sensor, {} AT, tip to tip, "
    "magnet {}: operates at {} to {} mm, releases at {} to {} mm; the means"
)


def _reed(
    part: str, turns: str, magnet: str, operate: tuple[float, float], release: tuple[float, float]
) -> Preset:
    """A sensor with a magnet of NdFeB; ranges in mm."""
    return Preset(
        f"{part}_{magnet}".replace("-", "_"),
        f"{part} with magnet {magnet}",
        {"close_distance": sum(operate) / 2000.0, "open_distance": sum(release) / 2000.0},
        REED_RELAYS.format(part, turns, magnet, *operate, *release),
    )


PRESETS: tuple[Preset, ...] = (
    _reed("MS-214-1", "10-15", "NDR-L", (15.5, 20.0), (18.5, 22.0)),
    _reed("MS-214-1", "10-15", "NDC-M", (10.5, 14.0), (13.0, 15.5)),
    _reed("MS-214-1", "10-15", "NDC-L", (29.0, 35.5), (33.0, 38.0)),
    _reed("MS-225", "10-15", "NDC-M", (8.0, 11.0), (10.0, 12.0)),
    _reed("MS-228", "20-25", "NDC-L", (21.0, 24.0), (29.0, 30.0)),
)

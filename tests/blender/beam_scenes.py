# SPDX-License-Identifier: GPL-3.0-or-later
"""Cards that pass the beam of a switch at the origin."""

FRAME = 1 / 24


def closed_at(world, recording, name="switch"):
    """Frames of the updates that read closed."""
    track = recording.tracks[name]
    opened = world.series(recording, name, "open")
    return [f for f, o in zip(track.frames, opened, strict=True) if not o]


def pass_beam(world, obj, at=10.5, speed=1.0, depth=-0.1, origin=(0, 0, 0)):
    """Keys: the object's origin is in the beam at frame `at`, m/s along x."""
    x, y, z = origin
    place = (at - 1) * FRAME * speed
    ends = {1: x - place, 24: x + 23 * FRAME * speed - place}
    world.key(obj, "location", {frame: (at_x, y, z + depth) for frame, at_x in ends.items()})
    world.scene.frame_end = 24
    return obj


def card_past(world, width=0.01, name="card", **way):
    return pass_beam(world, world.box((width, 0.1, 0.001), name=name), **way)

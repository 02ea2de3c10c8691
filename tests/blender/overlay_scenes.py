# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn of one sensor; a walker, and a detector that he passes."""

import math


def of(field, name):
    return next(seen for seen in field.seen if seen.sensor.name == name)


def random_walk(world):
    box = world.box((0.4, 1.8, 0.4), (0, 0, -1.5), name="walker")
    world.key(box, "location", {1: (-1.5, 0, -1.5), 40: (1.5, -0.4, -2.5), 48: (1.5, -0.4, -2.5)})
    return box


def make_pir(world):
    return world.pir(
        rays=31,
        vertical_fov=math.radians(30),
        vertical_step=math.radians(10),
        horizontal_fov=math.radians(90),
        threshold=0.05,
        update_rate=12.0,
    )

# SPDX-License-Identifier: GPL-3.0-or-later
"""A home's own keys and strips put aside: a day has its own story."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from ..scene.animation import all_animated


@contextmanager
def put_aside(scene: Any, but: Collection[Any] = ()) -> Iterator[None]:
    """Everything stands as at the scene's first frame, until the end; drivers, constraints and
    modifiers go on. `but`: datablocks that keep their keys. What is linked keeps its own too."""
    scene.frame_set(scene.frame_start)
    before = []
    for owner in list(all_animated()):
        data = owner.animation_data
        if owner.library is None and owner not in but and (data.action or data.nla_tracks):
            before.append((owner, data.action, getattr(data, "action_slot", None), data.use_nla))
            data.action, data.use_nla = None, False
    try:
        yield
    finally:
        for owner, action, slot, use_nla in before:
            data = owner.animation_data_create()
            data.action, data.use_nla = action, use_nla
            if slot is not None:
                data.action_slot = slot

# SPDX-License-Identifier: GPL-3.0-or-later
"""Collection instances in light scenes: without the housings of light sensors, which would shade
them, as these are left out of the scene itself too, and with panes that let light pass."""

from __future__ import annotations

from collections.abc import Callable, Container
from typing import Any

import bpy

from ..instances import is_holder, shown_in
from .panes import Panes


class Instances:
    """Stand-ins for panes, and for instances of collections with panes or such housings in them.
    `own`: what is to be called with all that is made, which goes with the light scene."""

    def __init__(self, own: Callable[[Any], Any], housings: Container[Any], panes: Panes) -> None:
        self._own = own
        self._housings = housings
        self._panes = panes
        self._differs: dict[Any, bool] = {}
        self._made: dict[Any, Any] = {}

    def stand_in(self, obj: Any, is_copy: bool = False) -> Any:
        """The object, or a copy of it that instances the same without housings, or whose panes let
        light pass; `is_copy`: it is one that may be changed."""
        if not is_holder(obj):
            return self._panes.stand_in(obj, is_copy)
        if not self._is_changed(obj.instance_collection):
            return obj
        copy = obj if is_copy else self._own(obj.copy())
        copy.instance_collection = self._without(obj.instance_collection)
        return copy

    def _is_changed(self, collection: Any) -> bool:
        if collection not in self._differs:
            # A damaged file may have it within itself.
            self._differs[collection] = False
            self._differs[collection] = any(
                obj in self._housings
                or self._panes.is_pane(obj)
                or (is_holder(obj) and self._is_changed(obj.instance_collection))
                for obj in shown_in(collection)
            )
        return self._differs[collection]

    def _without(self, collection: Any) -> Any:
        if collection not in self._made:
            made = self._made[collection] = self._own(bpy.data.collections.new(".angen_light"))
            made.instance_offset = collection.instance_offset
            for obj in shown_in(collection):
                if obj not in self._housings:
                    made.objects.link(self.stand_in(obj))
        return self._made[collection]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of whole arrays of meshes, which have too many points and faces for a walk over each."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

Facts = list[Any]


def mesh_facts(mesh: Any) -> Facts:
    """Vertices, faces and every attribute; only `is edited` in Edit Mode, when meshes cannot be
    read."""
    if mesh.is_editmode:
        return ["is edited"]
    found: Facts = [
        [getattr(m, "name_full", None) for m in mesh.materials],
        mesh.shape_keys.name_full if mesh.shape_keys else None,
    ]
    found += corners_and_faces(mesh)
    found.append(_attribute(mesh.attributes[".edge_verts"]) if mesh.edges else 0)
    for attribute in mesh.attributes:
        name = attribute.name
        if not name.startswith(".") and name not in {"position", "material_index"}:
            found.append((name, attribute.domain, _attribute(attribute)))
    return found


def corners_and_faces(mesh: Any) -> Facts:
    """Digests of the vertices' positions, the vertices of each face, and its material."""
    # Attributes are copied as whole arrays; item by item takes 50 times as long.
    found: Facts = [
        _attribute(mesh.attributes[name]) if name in mesh.attributes else 0
        for name in ("position", ".corner_vert")
    ]
    values = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", values)
    found.append(_hashed(values))
    # The attribute may be missing where all faces have the first material.
    values[:] = 0
    if "material_index" in mesh.attributes:
        mesh.attributes["material_index"].data.foreach_get("value", values)
    return [*found, _hashed(values)]


def _hashed(values: Any) -> str:
    """The digest of a long array, whose text would take many times its memory."""
    return hashlib.blake2b(values, digest_size=16).hexdigest()


def _attribute(attribute: Any) -> Any:
    data = attribute.data
    if not len(data):
        return 0
    name = next((n for n in ("value", "vector", "color") if hasattr(data[0], n)), None)
    if name is None or attribute.data_type == "STRING":
        return [str(getattr(item, "value", "")) for item in data]
    first = getattr(data[0], name)
    flat = np.ravel(first).size
    whole = attribute.data_type.startswith("INT") or (
        isinstance(first, int) and not isinstance(first, bool)
    )
    kind = np.int32 if whole else np.float32
    values = np.empty(len(data) * flat, bool if isinstance(first, bool) else kind)
    data.foreach_get(name, values)
    return _hashed(values)


def weights_of(mesh: Any) -> Any:
    """The groups and weights of each vertex that has any."""
    return [
        [(g.group, g.weight) for g in vertex.groups] for vertex in mesh.vertices if vertex.groups
    ]

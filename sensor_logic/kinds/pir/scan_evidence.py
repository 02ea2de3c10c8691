# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a range scan found movement or none: the ray that changed most, and what changed it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array, Index
from ...evidence import Cause, rows_of, rows_text
from ...kind import Field
from ...model import Pose, Updates

# m. Only noise changed a range if the range without noise changed by less than this.
SAME = 1e-6
SCAN = (("model", "RANGE_SCAN"),)
FIELDS = (
    Field("ago", int, tip="Updates since the scan before at the same tilts; −1 without one"),
    Field("tilt", int, tip="Tilt of the ray whose range changed most", used_when=SCAN),
    Field("ray", int, tip="Number of this ray; −1 if only noise changed ranges", used_when=SCAN),
    Field("before", float, "m", tip="Its range at the scan before", used_when=SCAN),
    Field("after", float, "m", tip="Its range at this scan", used_when=SCAN),
    Field("hit_before", str, tip="The object that it hit at the scan before", used_when=SCAN),
    Field("hit_after", str, tip="The object that it hits at this scan", used_when=SCAN),
    Field("culprit", str, tip="The object that changed its range; none: noise", used_when=SCAN),
    Field("over", str, tip="Rays above the threshold by the object that changed them"),
    Field("sensor_moved", float, "m", tip="How far the sensor moved between the scans"),
    Field("sensor_turned", float, "rad", tip="By how much the sensor turned between the scans"),
)


def cause_of_scan(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: the ray whose range changed most."""
    tilt, ray, before, after, culprit, over = (
        track.evidence.value(name, index)
        for name in ("tilt", "ray", "before", "after", "culprit", "over")
    )
    if ray < 0:
        return Cause()
    names: tuple[str, ...] = ()
    if culprit and abs(after - before) > track.parameters_at(index).threshold:
        names = (culprit, *(name for name, _ in rows_of(over) if name not in ("", culprit)))
    return Cause(names, f"tilt {tilt}, ray {ray}", "range_m", before, after)


ARRAYS = "ranges", "clean", "solids"


@dataclass(frozen=True, eq=False)
class Scan:
    """One scan of some tilts.

    Attributes
    ----------
    number
        The number of its update.
    pose
        The pose of the sensor.
    ranges, clean
        The ranges (tilts, rays) in m, with noise and without it.
    solids
        The numbers (tilts, rays) of the solids that the rays hit, 0 for none.
    """

    number: int
    pose: Pose
    ranges: Array
    clean: Array
    solids: Index

    def of_tilt(self, tilt: int) -> Scan:
        """Return the part of the scan at a tilt, given by its place among the scanned tilts."""
        row = slice(tilt, tilt + 1)
        return Scan(self.number, self.pose, *(getattr(self, name)[row] for name in ARRAYS))


def compare_scans(
    old: Scan, new: Scan, tilts: range, threshold: float, name_of: Callable[[int], str]
) -> dict[str, Any]:
    """Return the evidence of the scan `new` of some tilts, compared with the scan `old`.

    `threshold` is the change of a range in m that counts as movement. Where nothing but noise
    changed, and by less than that, the evidence has no ray: so it is equal for all such scans.
    """
    found: dict[str, Any] = {"ago": new.number - old.number}
    moved, turned = _movement(old.pose, new.pose)
    found |= {"sensor_moved": moved, "sensor_turned": turned}
    if old.ranges is new.ranges:
        return found
    changes = np.abs(new.ranges - old.ranges)
    row, ray = divmod(int(np.argmax(changes)), changes.shape[1])
    culprit = _culprit(old, new, row, ray)
    if not culprit and changes[row, ray] <= threshold:
        return found
    over = np.argwhere(changes > threshold).tolist()
    culprits = Counter(name_of(_culprit(old, new, *place)) for place in over)
    return found | {
        "tilt": tilts[row],
        "ray": ray,
        "before": float(old.ranges[row, ray]),
        "after": float(new.ranges[row, ray]),
        "hit_before": name_of(int(old.solids[row, ray])),
        "hit_after": name_of(int(new.solids[row, ray])),
        "culprit": name_of(culprit),
        "over": rows_text(sorted(culprits.items(), key=lambda item: (-item[1], item[0]))),
    }


def _culprit(old: Scan, new: Scan, row: int, ray: int) -> int:
    """Return the number of the solid that changed the range of a ray; 0 if noise did."""
    # The ray hit one solid before and one after the change. The nearer of the two came or left.
    before, after = float(old.clean[row, ray]), float(new.clean[row, ray])
    if abs(before - after) <= SAME:
        return 0
    nearer = old if before < after else new
    return int(nearer.solids[row, ray])


def _movement(old: Pose, new: Pose) -> tuple[float, float]:
    """Return how far a sensor moved (m), and by how much it turned (rad)."""
    if old.same(new):
        return 0.0, 0.0
    cosine = (float(np.trace(old.axes.T @ new.axes)) - 1.0) / 2.0
    turned = math.acos(max(-1.0, min(1.0, cosine)))
    return float(np.linalg.norm(new.origin - old.origin)), turned


class ScanEvidence:
    """The evidence of n updates: an array (n,) for each of `FIELDS`."""

    def __init__(self, updates: Updates, threshold: float) -> None:
        missing = {str: "", int: -1, float: 0.0}
        self.columns = {
            one.name: np.full(len(updates), missing[one.type], object if one.type is str else None)
            for one in FIELDS
        }
        self._numbers = updates.numbers
        self._how = threshold, updates.name_of

    def add(self, indices: Index, old: Scan | None, new: Scan, tilts: range) -> None:
        """Set the evidence of successive updates that all have the scan `new` of some tilts.

        `indices` (k,) are those of the updates, and `old` is the scan before the first of them.
        """
        if old is not None and old.ranges.shape == new.ranges.shape:
            for name, value in compare_scans(old, new, tilts, *self._how).items():
                self.columns[name][indices[0]] = value
        if len(indices) > 1:
            self.columns["ago"][indices[1:]] = np.diff(self._numbers[indices])


def stacked(scans: Sequence[Scan | None], new: Scan | None = None) -> Scan | None:
    """Return scans of one tilt each as one scan; None without any.

    A missing scan, or one with another number of rays, is replaced by that tilt of the scan `new`.
    """
    rays = None if new is None else new.ranges.shape[1]
    scans = [s if s and rays in (None, s.ranges.shape[1]) else None for s in scans]
    known = [s for s in scans if s is not None]
    if not known:
        return None
    parts = [s or new.of_tilt(i) for i, s in enumerate(scans)] if new else known
    if len(parts) == 1:
        return parts[0]
    arrays = (np.concatenate([getattr(p, name) for p in parts]) for name in ARRAYS)
    return Scan(known[0].number, known[0].pose, *arrays)

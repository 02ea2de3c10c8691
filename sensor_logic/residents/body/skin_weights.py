# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones move the skin of a person: smooth steps across the joints, in the rest pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...model import Array
from .skeleton import ANKLE, FOREARM, HIP, KNEE, SHOULDER, UPPER_ARM, WRIST
from .skin import shirt_body, sleeve
from .turns import ease


def _step(t: ArrayLike) -> Array:
    """0 below -1, 1 above +1, smooth between."""
    return ease(np.asarray(t) * 0.5 + 0.5)


def weights(points: Array, region: str) -> dict[str, Array]:
    """How much each bone moves each point: smooth steps across the joints, (n,) a bone."""
    if region == "head":
        found = _head(points)
    elif region in ("upper", "hand"):
        found = _upper(points, region == "hand")
    else:
        found = _lower(points, region == "foot")
    return {name: weight for name, weight in found.items() if weight.max() > 1e-4}


def _head(points: Array) -> dict[str, Array]:
    x, _, z = points.T
    head = _step((z + 0.35 * x - 1.535) / 0.035)
    neck = _step((z - 1.425) / 0.03)
    return {"head": head * neck, "neck": (1 - head) * neck, "chest": 1 - neck}


def _upper(points: Array, is_hand: bool) -> dict[str, Array]:
    """Trunk and arms, or a hand."""
    along_arm = (WRIST - SHOULDER) / np.linalg.norm(WRIST - SHOULDER)
    found: dict[str, Array] = {}
    rest = np.ones(len(points))
    for side, sign in (("L", 1.0), ("R", -1.0)):
        p = points * (1.0, sign, 1.0)
        arm: Array = (p[:, 1] > 0) * np.ones(len(p))
        along = (p - SHOULDER) @ along_arm
        if not is_hand:
            to_arm = sleeve()(p) - shirt_body()(p)
            out = _step(((p - SHOULDER) @ (0.0, 0.94, -0.34) - 0.005) / 0.065)
            arm = arm * _step(-to_arm / 0.06) * out
        below = _step((along - UPPER_ARM) / 0.05)
        hand = _step((along - UPPER_ARM - FOREARM - 0.002) / 0.022)
        found[f"upper_arm.{side}"] = arm * (1 - below)
        found[f"forearm.{side}"] = arm * below * (1 - hand)
        found[f"hand.{side}"] = arm * below * hand
        rest = rest - arm
    z = points[:, 2]
    chest, spine = _step((z - 1.17) / 0.08), _step((z - 1.04) / 0.07)
    found["chest"] = rest * chest
    found["spine"] = rest * (1 - chest) * spine
    found["pelvis"] = rest * (1 - chest) * (1 - spine)
    return found


def _lower(points: Array, is_foot: bool) -> dict[str, Array]:
    """Hips and legs, or a foot."""
    x, y, z = points.T
    left = (y > 0) * 1.0 if is_foot else _step(y / 0.02)
    found: dict[str, Array] = {}
    rest = np.ones(len(points))
    for side, sign, mine in (("L", 1.0, left), ("R", -1.0, 1 - left)):
        p = points * (1.0, sign, 1.0)
        # The fold of the hip runs from the crotch up and outwards.
        leg = mine * _step(((p - HIP) @ (0.0, 0.34, -0.94) - 0.0) / 0.075)
        shin = _step((KNEE[2] - z) / 0.065)
        foot = is_foot * _step((ANKLE[2] + 0.028 - z) / 0.025)
        toes = is_foot * _step((x - 0.118) / 0.022)
        found[f"thigh.{side}"] = leg * (1 - shin)
        found[f"shin.{side}"] = leg * shin * (1 - foot)
        found[f"foot.{side}"] = leg * shin * foot * (1 - toes)
        found[f"toes.{side}"] = leg * shin * foot * toes
        rest = rest - leg
    spine = (1 - is_foot) * _step((z - 1.04) / 0.07)
    found["spine"] = rest * spine
    found["pelvis"] = rest * (1 - spine)
    return found

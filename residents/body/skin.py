# SPDX-License-Identifier: GPL-3.0-or-later
"""The skin and clothes of a person as shapes in the rest pose, and their skinning weights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array
from . import surface as sf
from .skeleton import ANKLE, FOREARM, HIP, KNEE, KNUCKLES, SHOULDER, UPPER_ARM, WRIST
from .surface import Corner, Shape
from .turns import ease


@dataclass(frozen=True)
class Part:
    """A closed surface of a body, such as the hair.

    Attributes
    ----------
    name, material : str
        The names of the surface and of its material.
    shape : Shape
        The signed distance function.
    low, high : tuple of 3 floats
        The corners of a box around the surface, m.
    cell : float
        The edge length of the cells in which the shape is sampled, m.
    triangles : int
        The number of triangles.
    region : str
        The set of bones that move the surface; see `weights`.
    """

    name: str
    material: str
    shape: Shape
    low: Corner
    high: Corner
    cell: float
    triangles: int
    region: str  # the set of bones that move it: see `weights`


def _limb_axes(a: Array, b: Array, forward: tuple[float, float, float]) -> Array:
    """Return three axes of a limb as rows: front, side, and along it from `a` to `b`.

    The front is as near to `forward` as possible.
    """
    w = (b - a) / np.linalg.norm(b - a)
    u = np.asarray(forward) - w * (w @ forward)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(w, u), w])


def shirt_body() -> Shape:
    """Return the shape of the shirt without sleeves."""
    torso = sf.loft(
        (
            (0.875, -0.008, 0.136, 0.186),
            (0.95, -0.006, 0.128, 0.176),
            (1.05, 0.000, 0.112, 0.152),
            (1.14, 0.000, 0.112, 0.150),
            (1.25, 0.004, 0.122, 0.164),
            (1.32, 0.000, 0.120, 0.170),
            (1.38, -0.008, 0.100, 0.150),
            (1.425, -0.018, 0.072, 0.085),
            (1.452, -0.016, 0.064, 0.066),
        ),
        power=2.35,
        cap=0.015,
    )
    slope = sf.capsule((-0.022, 0.040, 1.428), (-0.012, 0.170, 1.386), 0.042, 0.060)
    chest = sf.ball((0.055, 0.07, 1.285), (0.062, 0.085, 0.065))
    blade = sf.ball((-0.065, 0.085, 1.28), (0.055, 0.075, 0.09))
    half = sf.union(0.04, slope, chest, blade)
    hollow = sf.ball((0.0, 0.0, 1.475), (0.062, 0.060, 0.035))
    return sf.cut(0.008, sf.union(0.05, torso, half, sf.mirrored(half)), hollow)


def sleeve() -> Shape:
    """Return the shape of the left sleeve."""
    axes = _limb_axes(SHOULDER, WRIST, (1, 0, 0))
    upper = sf.loft(
        (
            (-0.05, 0.0, 0.045, 0.040),
            (0.0, 0.0, 0.068, 0.064),
            (0.09, 0.004, 0.063, 0.060),
            (0.19, 0.004, 0.056, 0.054),
            (UPPER_ARM, 0.0, 0.046, 0.047),
            (UPPER_ARM + 0.07, 0.002, 0.047, 0.046),
            (UPPER_ARM + 0.16, 0.002, 0.042, 0.041),
            (UPPER_ARM + FOREARM - 0.005, 0.0, 0.036, 0.035),
        ),
        SHOULDER,
        axes,
        cap=0.02,
    )
    hollow = sf.capsule(WRIST - 0.004 * axes[2], WRIST + 0.05 * axes[2], 0.024, 0.026)
    return sf.cut(0.006, upper, hollow)


def shirt() -> Shape:
    """Return the shape of the shirt with both sleeves."""
    hollow = sf.ball((-0.006, 0, 0.855), (0.118, 0.168, 0.045))
    body = sf.cut(0.01, shirt_body(), hollow)
    return sf.union(0.035, body, sleeve(), sf.mirrored(sleeve()))


def trouser_leg() -> Shape:
    """Return the shape of the left trouser leg."""
    thigh = sf.loft(
        (
            (-0.05, 0.0, 0.080, 0.060),
            (0.03, -0.004, 0.094, 0.080),
            (0.12, -0.002, 0.087, 0.080),
            (0.26, 0.004, 0.072, 0.068),
            (0.40, 0.004, 0.060, 0.058),
            (0.47, 0.0, 0.056, 0.054),
        ),
        HIP,
        _limb_axes(HIP, KNEE, (1, 0, 0)),
        cap=0.03,
    )
    shin = sf.loft(
        (
            (-0.06, 0.0, 0.055, 0.054),
            (0.0, 0.002, 0.060, 0.057),
            (0.10, -0.010, 0.062, 0.058),
            (0.20, -0.008, 0.056, 0.053),
            (0.30, 0.0, 0.053, 0.050),
            (0.365, 0.006, 0.058, 0.052),
        ),
        KNEE,
        _limb_axes(KNEE, ANKLE, (1, 0, 0)),
        cap=0.012,
    )
    return sf.union(0.03, thigh, shin)


def trousers() -> Shape:
    """Return the shape of the trousers."""
    hips = sf.loft(
        (
            (0.80, -0.004, 0.070, 0.090),
            (0.85, -0.006, 0.104, 0.160),
            (0.90, -0.006, 0.112, 0.162),
            (0.96, -0.002, 0.098, 0.140),
            (1.02, 0.0, 0.085, 0.120),
        ),
        power=2.3,
        cap=0.02,
    )
    seat = sf.ball((-0.052, 0.068, 0.862), (0.074, 0.078, 0.078))
    legs = sf.union(0.012, trouser_leg(), sf.mirrored(trouser_leg()))
    return sf.union(0.045, hips, legs, seat, sf.mirrored(seat))


def shoe() -> Shape:
    """Return the shape of the left shoe."""
    x0 = ANKLE[0]
    turned = ((0, 0, 1), (0, 1, 0), (1, 0, 0))  # rings along the foot: height, width, length
    upper = sf.loft(
        (
            (-0.068, 0.030, 0.030, 0.026),
            (-0.045, 0.034, 0.052, 0.036),
            (0.0, 0.034, 0.062, 0.037),
            (0.05, 0.022, 0.055, 0.039),
            (0.10, 0.012, 0.044, 0.046),
            (0.15, 0.008, 0.036, 0.047),
            (0.185, 0.006, 0.030, 0.040),
            (0.208, 0.006, 0.022, 0.024),
        ),
        (x0, ANKLE[1] + 0.004, 0.0),
        turned,
        power=2.5,
        cap=0.02,
    )
    ankle = sf.capsule(ANKLE + (0, 0, -0.02), ANKLE + (-0.002, 0, 0.05), 0.042, 0.040)

    def under(points: Array) -> Array:
        return points[:, 2]

    return sf.cut(0.008, sf.union(0.03, upper, ankle), under)


def hand() -> Shape:
    """Return the shape of the left hand, with the palm to the thigh and slightly bent fingers."""
    axes = _limb_axes(WRIST, KNUCKLES, (1, 0, 0))  # front, side, down the arm

    def at(front: float, side: float, down: float) -> Array:
        return WRIST + np.array([front, side, down]) @ axes

    inward = 1.0 if axes[1][1] < 0 else -1.0  # sign of the side that looks at the thigh
    palm = sf.loft(
        (
            (-0.03, 0.0, 0.026, 0.021),
            (0.0, 0.0, 0.027, 0.020),
            (0.03, 0.002, 0.034, 0.018),
            (0.075, 0.002, 0.041, 0.015),
            (0.098, 0.002, 0.038, 0.012),
        ),
        WRIST,
        axes,
        power=2.4,
        cap=0.01,
    )
    shapes = [palm]
    lengths = (0.066, 0.076, 0.071, 0.055)
    for i, length in enumerate(lengths):
        front = 0.031 - 0.020 * i
        a = at(front, 0.0, 0.088)
        b = at(front * 1.05, inward * 0.010, 0.088 + 0.55 * length)
        c = at(front * 1.05, inward * 0.028, 0.088 + 0.92 * length)
        shapes.append(
            sf.union(0.004, sf.capsule(a, b, 0.0100, 0.0092), sf.capsule(b, c, 0.0092, 0.0078))
        )
    thumb = sf.union(
        0.006,
        sf.capsule(
            at(0.024, inward * 0.006, 0.022), at(0.047, inward * 0.018, 0.060), 0.016, 0.012
        ),
        sf.capsule(
            at(0.047, inward * 0.018, 0.060), at(0.052, inward * 0.024, 0.098), 0.011, 0.0085
        ),
    )
    return sf.union(0.008, *shapes, thumb)


SKULL = ((-0.008, 0.0, 1.622), (0.096, 0.076, 0.097))


def head() -> Shape:
    """Return the shape of head and neck."""
    skull = sf.ball(*SKULL)
    face = sf.ball((0.030, 0.0, 1.585), (0.060, 0.056, 0.082))
    jaw = sf.union(
        0.03,
        sf.capsule((0.068, 0.012, 1.522), (0.008, 0.044, 1.550), 0.016, 0.018),
        sf.capsule((0.068, -0.012, 1.522), (0.008, -0.044, 1.550), 0.016, 0.018),
        sf.capsule((0.062, 0.0, 1.527), (0.064, 0.0, 1.56), 0.022, 0.026),
    )
    neck = sf.loft(
        (
            (1.38, -0.022, 0.060, 0.062),
            (1.44, -0.020, 0.055, 0.056),
            (1.50, -0.012, 0.053, 0.052),
            (1.56, -0.010, 0.058, 0.054),
        ),
        power=2.0,
        cap=0.01,
    )
    nose = sf.union(
        0.01,
        sf.capsule((0.088, 0, 1.628), (0.109, 0, 1.592), 0.008, 0.0115),
        sf.ball((0.100, 0.012, 1.587), 0.009),
        sf.ball((0.100, -0.012, 1.587), 0.009),
    )
    brow = sf.capsule((0.082, 0.012, 1.640), (0.064, 0.048, 1.638), 0.010, 0.010)
    cheek = sf.ball((0.062, 0.038, 1.590), (0.024, 0.022, 0.022))
    ear = sf.ball((-0.012, 0.080, 1.606), (0.019, 0.011, 0.031))
    socket = sf.ball((0.094, 0.032, 1.622), (0.017, 0.019, 0.013))
    body = sf.union(0.035, skull, face, jaw, neck)
    for shape in (brow, cheek):
        body = sf.union(0.02, body, shape, sf.mirrored(shape))
    body = sf.union(0.012, body, nose)
    body = sf.union(0.008, body, ear, sf.mirrored(ear))
    return sf.cut(0.015, body, socket, sf.mirrored(socket))


def hair() -> Shape:
    """Return the shape of the hair."""
    cap = sf.union(
        0.03,
        sf.ball((-0.012, 0.0, 1.628), (0.106, 0.087, 0.104)),
        sf.ball((0.048, 0.020, 1.690), (0.050, 0.055, 0.030)),
        sf.ball((-0.070, 0.0, 1.575), (0.042, 0.062, 0.060)),
    )
    line_x = np.array([-0.14, -0.06, -0.030, -0.022, 0.016, 0.022, 0.050, 0.13])
    line_z = np.array([1.520, 1.530, 1.570, 1.642, 1.642, 1.600, 1.655, 1.690])

    def below(p: Array) -> Array:
        return (p[:, 2] - sf.smooth_table(line_x, line_z, p[:, 0])) * 0.6

    return sf.cut(0.012, cap, below)


def face_details() -> list[Part]:
    """Return the surfaces of eyes, brows and mouth."""
    parts = []

    def add(name: str, material: str, shape: Shape, low: Corner, high: Corner, n: int) -> None:
        parts.append(Part(name, material, shape, low, high, 0.003, n, "head"))

    eye = sf.ball((0.0735, 0.031, 1.622), (0.0125, 0.0150, 0.0075))
    iris = sf.ball((0.0830, 0.0315, 1.622), (0.0042, 0.0060, 0.0066))
    brow = sf.union(
        0.005,
        sf.capsule((0.0915, 0.016, 1.6445), (0.086, 0.034, 1.6465), 0.0036, 0.0036),
        sf.capsule((0.086, 0.034, 1.6465), (0.073, 0.049, 1.640), 0.0036, 0.0026),
    )
    for sign, side in ((1, "L"), (-1, "R")):
        for name, material, shape, n in (
            ("eye", "eye white", eye, 60),
            ("iris", "iris", iris, 40),
            ("brow", "hair", brow, 40),
        ):
            part = shape if sign > 0 else sf.mirrored(shape)
            y = (0.005, 0.06) if sign > 0 else (-0.06, -0.005)
            add(f"{name}.{side}", material, part, (0.055, y[0], 1.60), (0.105, y[1], 1.66), n)
    corner = (0.0915, 0.023, 1.5590)
    half = sf.union(
        0.004,
        sf.capsule((0.0965, 0.0, 1.5610), corner, 0.0052, 0.0030),
        sf.capsule((0.0965, 0.0, 1.5535), corner, 0.0062, 0.0030),
    )
    lip = sf.union(0.004, half, sf.mirrored(half))
    add("lips", "lips", lip, (0.08, -0.035, 1.54), (0.11, 0.035, 1.575), 80)
    return parts


def person_parts() -> list[Part]:
    """Return the closed surfaces of a person, about 5500 triangles."""
    whole = [
        Part("shirt", "shirt", shirt(), (-0.16, -0.50, 0.86), (0.17, 0.50, 1.50), 0.013, 1500,
             "upper"),
        Part("trousers", "trousers", trousers(), (-0.16, -0.22, 0.09), (0.15, 0.22, 1.05), 0.013,
             1300, "lower"),
        Part("head", "skin", head(), (-0.13, -0.10, 1.37), (0.13, 0.10, 1.73), 0.0075, 1100,
             "head"),
        Part("hair", "hair", hair(), (-0.14, -0.11, 1.49), (0.12, 0.11, 1.76), 0.0085, 450,
             "head"),
    ]  # fmt: skip
    return [*whole, *_shoes_and_hands(), *face_details()]


def _shoes_and_hands() -> list[Part]:
    left = [
        Part("shoe.L", "shoe", shoe(), (-0.10, 0.05, -0.01), (0.22, 0.19, 0.19), 0.010, 260,
             "foot"),
        Part("hand.L", "hand", hand(), (-0.06, 0.36, 0.72), (0.10, 0.56, 0.98), 0.0055, 360,
             "hand"),
    ]  # fmt: skip
    right = [
        replace(
            part,
            name=part.name.replace(".L", ".R"),
            shape=sf.mirrored(part.shape),
            low=(part.low[0], -part.high[1], part.low[2]),
            high=(part.high[0], -part.low[1], part.high[2]),
        )
        for part in left
    ]
    return [*left, *right]


# The weights of the bones.


def _smooth_step(t: ArrayLike) -> Array:
    """Return a smooth step of `t`, which rises from 0 at −1 to 1 at +1."""
    return ease(np.asarray(t) * 0.5 + 0.5)


def weights(points: Array, region: str) -> dict[str, Array]:
    """Return the skinning weights (n,) of each bone at points (n, 3) of a region, by bone name.

    The weights change smoothly across the joints. The points are on the body in its rest pose, m.
    """
    if region == "head":
        found = _head(points)
    elif region in ("upper", "hand"):
        found = _upper_weights(points, region == "hand")
    else:
        found = _lower_weights(points, region == "foot")
    return {name: weight for name, weight in found.items() if weight.max() > 1e-4}


def _head(points: Array) -> dict[str, Array]:
    x, _, z = points.T
    head = _smooth_step((z + 0.35 * x - 1.535) / 0.035)
    neck = _smooth_step((z - 1.425) / 0.03)
    return {"head": head * neck, "neck": (1 - head) * neck, "chest": 1 - neck}


def _upper_weights(points: Array, is_hand: bool) -> dict[str, Array]:
    """Return the weights of the bones of trunk and arms; if `is_hand`, those for the hands."""
    along_arm = (WRIST - SHOULDER) / np.linalg.norm(WRIST - SHOULDER)
    found: dict[str, Array] = {}
    rest = np.ones(len(points))
    for side, sign in (("L", 1.0), ("R", -1.0)):
        p = points * (1.0, sign, 1.0)
        arm: Array = (p[:, 1] > 0) * np.ones(len(p))
        along = (p - SHOULDER) @ along_arm
        if not is_hand:
            to_arm = sleeve()(p) - shirt_body()(p)
            out = _smooth_step(((p - SHOULDER) @ (0.0, 0.94, -0.34) - 0.005) / 0.065)
            arm = arm * _smooth_step(-to_arm / 0.06) * out
        below = _smooth_step((along - UPPER_ARM) / 0.05)
        hand = _smooth_step((along - UPPER_ARM - FOREARM - 0.002) / 0.022)
        found[f"upper_arm.{side}"] = arm * (1 - below)
        found[f"forearm.{side}"] = arm * below * (1 - hand)
        found[f"hand.{side}"] = arm * below * hand
        rest = rest - arm
    z = points[:, 2]
    chest, spine = _smooth_step((z - 1.17) / 0.08), _smooth_step((z - 1.04) / 0.07)
    found["chest"] = rest * chest
    found["spine"] = rest * (1 - chest) * spine
    found["pelvis"] = rest * (1 - chest) * (1 - spine)
    return found


def _lower_weights(points: Array, is_foot: bool) -> dict[str, Array]:
    """Return the weights of the bones of hips and legs; if `is_foot`, those for the feet."""
    x, y, z = points.T
    left = (y > 0) * 1.0 if is_foot else _smooth_step(y / 0.02)
    found: dict[str, Array] = {}
    rest = np.ones(len(points))
    for side, sign, mine in (("L", 1.0, left), ("R", -1.0, 1 - left)):
        p = points * (1.0, sign, 1.0)
        # The fold of the hip runs from the crotch up and outwards.
        leg = mine * _smooth_step(((p - HIP) @ (0.0, 0.34, -0.94) - 0.0) / 0.075)
        shin = _smooth_step((KNEE[2] - z) / 0.065)
        foot = is_foot * _smooth_step((ANKLE[2] + 0.028 - z) / 0.025)
        toes = is_foot * _smooth_step((x - 0.118) / 0.022)
        found[f"thigh.{side}"] = leg * (1 - shin)
        found[f"shin.{side}"] = leg * shin * (1 - foot)
        found[f"foot.{side}"] = leg * shin * foot * (1 - toes)
        found[f"toes.{side}"] = leg * shin * foot * toes
        rest = rest - leg
    spine = (1 - is_foot) * _smooth_step((z - 1.04) / 0.07)
    found["spine"] = rest * spine
    found["pelvis"] = rest * (1 - spine)
    return found

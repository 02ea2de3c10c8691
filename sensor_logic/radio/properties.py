# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of objects and materials that radars need: their substance, and breathing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ..kind import OwnerProperties
from ..parameters import Choice, Parameters, parameter
from .substances import SUBSTANCES

AUTO, YES, NO = "AUTO", "YES", "NO"
# With *Automatic*, a thin object is textile if its name, or the names of all its materials, contain
# one of these words, but not if a word of what cloth hangs or lies on ends its name: a blanket
# cupboard is a cupboard, and a wall curtain a curtain.
TEXTILE_WORDS = (
    "blanket", "carpet", "cloth", "cotton", "curtain", "cushion", "drape", "duvet", "fabric",
    "linen", "pillow", "quilt", "textile", "towel", "upholster", "velvet", "wool",
)  # fmt: skip
HOLDER_WORDS = (
    "bar", "box", "cabinet", "chest", "closet", "cupboard", "door", "dryer", "heater", "holder",
    "hook", "pole", "rack", "radiator", "rail", "rod", "shelf", "wall", "wardrobe",
    "warmer",
)  # fmt: skip
# A holder is a whole word, or the end of one, such as of "CurtainRails".
SAYS_TEXTILE = re.compile("|".join(TEXTILE_WORDS))
SAYS_HOLDER = re.compile(rf"(?:{'|'.join(HOLDER_WORDS)})s?(?![a-z])")
# m: the greatest thickness of a duvet, a cushion or a folded curtain. Anything thicker is not thin.
THIN = 0.3
# The usual thickness in m of what waves pass in one crossing of a wall, door or pane: two boards on
# studs, a door leaf, double glazing.
THICKNESS = {
    "CONCRETE": 0.2, "BRICK": 0.1, "PLASTERBOARD": 0.025, "WOOD": 0.04, "GLASS": 0.008,
    "CHIPBOARD": 0.02, "PLYWOOD": 0.02, "METAL": 0.001, "BODY": 0.2,
    # Assumed: the cloth and the filling of a duvet without the air in them.
    "TEXTILE": 0.003,
}  # fmt: skip
TIPS = {
    "PLASTERBOARD": "Thin walls of boards on studs: radars see through them",
    "WOOD": "Solid wood, such as doors and furniture",
    "GLASS": "Panes",
    "CHIPBOARD": "Chipboard, such as cupboards",
    "PLYWOOD": "Plywood",
    "CONCRETE": "Concrete: stops the waves",
    "BRICK": "Brick: stops most of the waves",
    "METAL": "Metal: reflects all waves",
    "BODY": "A person or an animal: skin",
    "TEXTILE": "Curtains, duvets and upholstery: radars see through them",
}


def is_textile(name: str, materials: Sequence[str]) -> bool:
    """Return whether a thin object is textile, by its name and the names of its materials."""

    def last(words: re.Pattern[str], text: str) -> int:
        return max((found.start() for found in words.finditer(text.lower())), default=-1)

    textile, holder = last(SAYS_TEXTILE, name), last(SAYS_HOLDER, name)
    if holder > textile:
        return False
    of_cloth = [last(SAYS_TEXTILE, material) >= 0 for material in materials]
    return textile >= 0 or (bool(of_cloth) and all(of_cloth))


@dataclass(frozen=True)
class RadarSubstance(Parameters):
    """What an object or a material is made of, for radars."""

    substance: str = parameter(
        AUTO,
        "Substance",
        "What radars' waves meet. An object's own substance counts before that of its materials",
        choices=(
            Choice(
                AUTO,
                "Automatic",
                "Of an object: as its materials, or else a body if an armature bends it and it has "
                "a mass (Weight on Sensors), textile if it has a cloth modifier or is thin and its "
                "name or its materials' names say so, such as curtain, or else concrete. Of a "
                "material: not set",
                0,
            ),
            *(
                Choice(name, name.capitalize(), TIPS[name], number)
                for number, name in enumerate(SUBSTANCES, 1)
            ),
        ),
    )
    thickness: float = parameter(
        0.0,
        "Thickness",
        "How much of the substance waves pass at one crossing, such as both boards of a wall. 0: "
        "the usual thickness of the substance",
        unit="m",
    )


@dataclass(frozen=True)
class Breathing(Parameters):
    """The breathing of a body that need not move in the scene.

    References
    ----------
    .. [1] A. De Groote, M. Wantier, G. Cheron, M. Estenne, M. Paiva, "Chest wall motion during
       tidal breathing", J. Appl. Physiol. 83 (1997): the chest moves by 4 to 12 mm.
    """

    breathes: str = parameter(
        AUTO,
        "Breathes",
        "Whether radars see this object breathe",
        choices=(
            Choice(
                AUTO,
                "Automatic",
                "If it is a body: bent by an armature, with a mass (Weight on Sensors)",
                0,
            ),
            Choice(YES, "Yes", "It breathes", 1),
            Choice(NO, "No", "It does not breathe", 2),
        ),
    )
    displacement: float = parameter(
        0.005,
        "Displacement",
        "How far the chest moves from breathing out to breathing in",
        unit="m",
        maximum=0.05,
        source="4 to 12 mm: De Groote et al. 1997",
    )
    rate: float = parameter(
        0.25,
        "Breathing rate",
        "Breaths per second. An adult at rest: 0.2 to 0.33 Hz",
        unit="Hz",
        positive=True,
        maximum=2.0,
    )


OWNER_PROPERTIES = (
    OwnerProperties(
        "angen_radar",
        ("Object", "Material"),
        "Radar Substance",
        "What this is made of, which decides whether radars see through it",
        RadarSubstance,
    ),
    OwnerProperties(
        "angen_breathing",
        ("Object",),
        "Breathing",
        "Breathing, which radars see although nothing else moves",
        Breathing,
    ),
)

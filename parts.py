# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the extension: modules that register with Blender, and subcommands of `angen`.

The code calls a subcommand, such as `angen simulate`, a verb. Modules are registered, and verbs are
shown, in the order of the lists here. If a folder of the root package is not installed, its modules
and verbs are left out. So the sensors work without the residents. The extension's zip lacks the
verb `study`; the command line then says how to install it.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

# Each module has `register` and `unregister`. Later modules may need earlier ones, and panels come
# in the order of the sidebar.
MODULES = (
    "angen_addon.properties",
    "residents.blender.marks",
    "residents.blender.settings",
    "angen_addon.view.active",
    "angen_addon.appearance.help",
    "angen_addon.appearance.pixel_icons",
    "angen_addon.view.overlay.settings",
    "angen_addon.view.overlay.hover",
    "angen_addon.view.gizmos",
    "angen_addon.view.overlay.draw",
    "angen_addon.view.overlay.refresh",
    "residents.blender.places_drawn",
    "angen_addon.view.timeline.settings",
    "angen_addon.view.timeline.draw",
    "angen_addon.coverage.settings",
    "angen_addon.coverage.shown",
    "angen_addon.authoring.dropped",
    "residents.blender.day_settings",
    "residents.blender.still",
    "operators.add",
    "operators.place",
    "residents.operators.places",
    "operators.assign",
    "operators.copy",
    "operators.door",
    "operators.preset",
    "operators.user_preset",
    "operators.simulate",
    "operators.measure_light",
    "operators.bake",
    "operators.recording",
    "operators.export",
    "operators.export_format",
    "operators.layout_files",
    "operators.lacking",
    "operators.report",
    "operators.event_jump",
    "operators.markers",
    "operators.explain",
    "operators.show",
    "operators.sign_select",
    "operators.instance_override",
    "operators.warmth",
    "residents.operators.resident_add",
    "residents.operators.day",
    "residents.operators.day_run",
    "operators.coverage",
    "operators.propose",
    "operators.doctor",
    "operators.live_mqtt",
    "studies.window.operators",
    "panels.presets",
    "panels.physics_tab",
    "panels.table",
    "panels.sidebar",
    "panels.live_mqtt",
    "panels.events",
    "panels.active_sensor",
    "panels.overlay",
    "panels.load",
    "panels.warmth",
    "panels.owner_properties",
    "panels.coverage",
    "residents.panels.residents",
    "residents.panels.places",
    "residents.panels.strip",
    "residents.panels.day",
    "studies.window.panel",
    "panels.doctor",
    "angen_addon.runtime.handlers",
    "angen_addon.commands.command_line",
    # Its dictionaries have the names of the properties of all others.
    "angen_addon.translations.interface",
    # Last, so that it ends what goes on before the rest is unregistered.
    "operators.long_work",
)

# The verbs that work on a blend file, in the order of the help. Each has the module whose `VERBS`
# contains its `Verb` (angen_addon/commands/parser.py).
VERBS = {
    "simulate": "angen_addon.commands.simulate",
    "list": "angen_addon.commands.verbs",
    "apply": "angen_addon.commands.verbs",
    "check": "angen_addon.commands.verbs",
    "explain": "angen_addon.commands.verbs",
    "coverage": "angen_addon.coverage.command",
    "place": "angen_addon.coverage.command",
    "places": "residents.blender.command",
    "day": "residents.blender.command",
    "doctor": "angen_addon.commands.verbs",
}
# The verbs that need no blend file; `main(options, program)` returns the exit status. A verb whose
# folder no extra installs is left out with it, below.
WITHOUT_BLENDER = {
    "convert": "angen_addon.commands.convert",
    "compare": "angen_addon.commands.compare",
    "replay": "angen_addon.commands.replay",
    "learn": "residents.blender.learn",
    "study": "studies.command",
}
# The folders that the zip lacks, each with the extra of the Python package that installs it.
EXTRAS = {"studies": "study"}
# The packages without which a house shows nothing in the window.
NEEDED = {"studies": ("distributed", "jinja2", "pandas")}


def installed(name: str) -> bool:
    """Return whether the top-level folder of the module `name` is installed."""
    return find_spec(f".{name.partition('.')[0]}", __package__) is not None


def runs_here(name: str) -> bool:
    """Return whether the module `name` is installed, with all that its house needs."""
    house = name.partition(".")[0]
    return installed(name) and all(map(find_spec, NEEDED.get(house, ())))


WITHOUT_BLENDER = {
    verb: name
    for verb, name in WITHOUT_BLENDER.items()
    if name.partition(".")[0] in EXTRAS or installed(name)
}


def installation(house: str) -> str:
    """Return a text that says how to install the folder `house`, which the extension lacks."""
    return f"{install_command(EXTRAS[house])} in the project's folder"


def install_command(extra: str) -> str:
    """Return the shell command that installs the package with an extra, in the project's folder."""
    return f'pip install ".[{extra}]"'


def part(name: str) -> Any:
    """Import and return the module `name` of the extension."""
    return import_module(f".{name}", __package__)

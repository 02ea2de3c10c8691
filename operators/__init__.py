# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: one file for each thing that a user does."""


def _modules() -> tuple:
    from . import (
        add,
        assign,
        bake,
        copy,
        coverage,
        day,
        doctor,
        door,
        event_jump,
        explain,
        export,
        export_format,
        import_layout,
        instance_override,
        lacking,
        markers,
        place,
        places,
        preset,
        propose,
        recording,
        report,
        resident_add,
        show,
        simulate,
        study,
        user_preset,
        warmth,
    )

    return (
        add, place, places, assign, copy, door, preset, user_preset, simulate, bake, recording,
        export, export_format, import_layout, lacking, report, event_jump, markers, explain, show,
        instance_override, warmth, resident_add, day, coverage, propose, doctor, study,
    )  # fmt: skip


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()

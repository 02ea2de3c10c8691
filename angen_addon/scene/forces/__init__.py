# SPDX-License-Identifier: GPL-3.0-or-later
"""What presses on what: the bodies of a scene, their shapes and their motion."""

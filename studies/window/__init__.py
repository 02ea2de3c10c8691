# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators and the panel that write studies, in Blender's window."""

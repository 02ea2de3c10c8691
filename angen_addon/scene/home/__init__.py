# SPDX-License-Identifier: GPL-3.0-or-later
"""The home as rays see it: its solids in metres, surfaces to place sensors on, floors and rooms."""

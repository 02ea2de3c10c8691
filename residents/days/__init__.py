# SPDX-License-Identifier: GPL-3.0-or-later
"""Days that were lived in a home: their truth beside the events, daylight, and how days become one
folder. Without Blender; what runs a day is `residents/blender/run.py`."""

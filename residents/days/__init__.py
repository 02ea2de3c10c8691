# SPDX-License-Identifier: GPL-3.0-or-later
"""Days of a home: their events, what people did, daylight, and the files of several days.

Nothing here needs Blender; `residents/blender/run.py` simulates a day.
"""

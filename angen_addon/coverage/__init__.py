# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps of the motion detectors of a scene, and proposals of places for new ones.

`floor` finds where people can move. `maps` casts the rays of each detector and computes the map.
`proposal` searches places for new detectors. `shown` and `command` show the results.
"""

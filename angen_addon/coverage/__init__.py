# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps of the motion detectors of a scene, and proposals of places for new ones.

`floor` finds where people can move. `maps` casts the rays of each detector and computes the map.
`proposal` searches for places of new detectors. `shown` shows the results in the scene, and
`command` prints them without a window.
"""

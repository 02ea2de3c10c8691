# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of where motion detectors notice motions, and proposals of poses for new detectors.

`floor` finds where people can move. `maps` casts the rays of each detector and computes the map.
`proposal` searches for poses of new detectors. `shown` shows the results in the scene, and
`command` prints them without a window.
"""

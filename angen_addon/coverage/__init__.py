# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps of the motion detectors of a scene, and proposals where to put them.

`floor` finds where somebody can move; `maps` casts each detector's rays and puts both together;
`proposal` looks for places of new detectors. `shown` and `command` show what was found.
"""

# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of ambient sensors, and their logs: numpy and the standard library, no Blender.

`logs/` imports no model. So that logs know the fields of all kinds, loading this package loads the
kinds.
"""

from . import kinds as kinds

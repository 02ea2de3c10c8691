# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact between rigid bodies: where they touch, and the forces that follow from their motion."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""The light at sensors, rendered by `probe` once `scene.changes` says that it can have changed."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""Logs: what sensors said, read and written without Blender and without any sensor model."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""Layouts: the sensors of a home as a JSON file, which users write and `list --json` prints."""

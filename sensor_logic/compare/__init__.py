# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares two logs: how long and how often sensors are on, and how much the logs differ."""

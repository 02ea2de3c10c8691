# SPDX-License-Identifier: GPL-3.0-or-later
"""Two logs beside each other: how long sensors are on, how often, and how alike both are."""

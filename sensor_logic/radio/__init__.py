# SPDX-License-Identifier: GPL-3.0-or-later
"""Radio waves in a home: what radars query, and the properties of materials and bodies."""

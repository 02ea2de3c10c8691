# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes new sensors: parameters of known parts, housings, and placing on surfaces."""

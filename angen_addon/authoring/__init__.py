# SPDX-License-Identifier: GPL-3.0-or-later
"""New sensors: the parts they are of, their housings, and how they stand on surfaces."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""The marks on a home's objects for its residents: places, doors, lamps."""

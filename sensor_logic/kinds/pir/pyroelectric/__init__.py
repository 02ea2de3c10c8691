# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion detector as it is built: lens, two elements, amplifier, comparator."""

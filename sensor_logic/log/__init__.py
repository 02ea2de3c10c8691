# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log and the texts in its fields."""

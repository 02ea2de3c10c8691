# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run leaves: kept in memory and in the file, told to be stale, keyed."""

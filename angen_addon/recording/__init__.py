# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run leaves: kept in memory and in the file, compared with the scene, keyed."""

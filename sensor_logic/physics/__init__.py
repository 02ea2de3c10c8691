# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of circuits: voltage divider, converter, output stage, photometry."""

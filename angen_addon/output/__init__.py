# SPDX-License-Identifier: GPL-3.0-or-later
"""What is written of a run: files, reports, formats of other tools."""

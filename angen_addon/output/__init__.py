# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing of results: logs, reports, and formats of other tools."""

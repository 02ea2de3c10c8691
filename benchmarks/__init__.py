# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against error, each with its reference. Run with `make bench`."""

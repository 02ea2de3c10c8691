# SPDX-License-Identifier: GPL-3.0-or-later
"""What in a file keeps sensors from reading what its user expects, and the way out."""

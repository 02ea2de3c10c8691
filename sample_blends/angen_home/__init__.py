# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample home, built from nothing; a resident of the product lives in it."""

from angen_addon.process.standalone import load_extension

load_extension()

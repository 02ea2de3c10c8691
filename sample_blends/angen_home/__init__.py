# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample home, built from nothing; its person moves by the product's own modules."""

from angen_addon.process.standalone import load_extension

load_extension()

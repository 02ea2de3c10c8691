# SPDX-License-Identifier: GPL-3.0-or-later
"""The Ängen home, built from an empty file, with one of the extension's residents."""

from angen_addon.process.standalone import load_extension

load_extension()

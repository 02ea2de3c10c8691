# SPDX-License-Identifier: GPL-3.0-or-later
"""The Ängen home: modules that build the sample scene from the figures in `plan`."""

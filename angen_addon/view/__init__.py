# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown of sensors: in the viewport, in the timeline, as a plan, in words."""

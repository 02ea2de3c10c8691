# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of custom properties that say what the extension itself made in a file."""

# On objects, collections, meshes and materials of coverage maps and proposals, which no sensor
# sees; what else of them is kept with the scene begins with it.
COVERAGE_MARK = "angen_coverage"
# On ways that Check Places drew, which no sensor sees.
WAY_MARK = "angen_way"
# On what was made for light scenes.
LIGHT_MARK = "angen_light_made"

# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the custom properties on data that the extension makes in a file."""

# On objects, collections, meshes and materials of coverage maps and proposals, which no sensor
# sees. Other custom properties of these begin with the same name.
COVERAGE_MARK = "angen_coverage"
# On the curves that Check Places draws for ways, which no sensor sees.
WAY_MARK = "angen_way"
# On the meshes of sensors' housings that the extension made, which other sensors see through.
HOUSING_MARK = "angen_housing"
# On datablocks that were made for light scenes.
LIGHT_MARK = "angen_light_made"

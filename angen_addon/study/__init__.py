# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies, run by Dask outside Blender: `tasks` and `home_run` are what a worker does, `cluster`
and `engine` what the driver does, `results` what is kept, `report` what is shown of it."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""What `import angen_sensors` gives to scripts and notebooks: homes, their sensors, recordings.

`recording` needs no Blender: what a worker process sends back is read where there is none.
"""

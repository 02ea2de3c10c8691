# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's folders as the package `angen_sensors`; all else is in pyproject.toml."""

from setuptools import find_packages, setup

NAME = "angen_sensors"
FOLDERS = find_packages(
    include=[*("angen_addon*", "operators*", "panels*", "residents*", "sensor_logic*", "studies*")]
)

setup(package_dir={NAME: "."}, packages=[NAME, *(f"{NAME}.{folder}" for folder in FOLDERS)])

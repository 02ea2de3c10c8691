# SPDX-License-Identifier: GPL-3.0-or-later
"""Publishing of sensors as live devices at an MQTT broker.

Only the module `link` needs paho-mqtt, which it imports when it connects. Only the module `sending`
needs Blender.
"""

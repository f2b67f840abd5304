"""Black-box checks of the DeviceNet sensors tiltix080 and tiltix360.

The expected behaviour is that of POSITAL's manual of the TILTIX sensors, or else that of a Group 2 Only slave of DeviceNet.
T1..T30 are the decisions in core/src/model/tiltix/README.md: what the sensor does where the manual is unclear or contradicts
itself.
"""

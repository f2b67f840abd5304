"""Black-box checks of the sensors with GEMAC's function select codes (FSC).

The expected behaviour is that of the user manual "Inclination Sensors with CAN Bus Interface", version 1.7 (2021-07-30), and for
the older types that of the German manual of IS1D 00 P20 / IS2D 90 P20. Section and table numbers are those of the manual of 2021
unless another manual is named. G1..G30 are the decisions in core/src/model/gemac/README.md: what the sensor does where the manual
is unclear or contradicts itself.
"""

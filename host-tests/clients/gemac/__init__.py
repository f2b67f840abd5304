"""Black-box checks of the sensors that speak GEMAC's function select codes (FSC).

Everything that is expected here is taken from the user manual "Inclination Sensors with CAN Bus Interface", version 1.7
(2021-07-30), and for the older types from the German manual of IS1D 00 P20 / IS2D 90 P20. Section and table numbers are those of
the manual of 2021 unless said otherwise. G1..G30 are the decisions where the manual is open or contradicts itself.
"""

"""Black-box checks of the CANopen sensor JN2101.

Everything that is expected here is taken from ifm's device manual of JN2101 (firmware 2.2.0), whose section numbers are given,
and where it says nothing from CiA 301. J1..J13 are the decisions where the manual is open or contradicts itself. `cases.md` tells
which check covers which case of CiA's conformance test.
"""

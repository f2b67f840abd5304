"""Black-box checks of the CANopen sensors JN2101 and, in the modules `ims360_*`, IMS360.

The expected behaviour is that of ifm's device manual of the JN2101 (firmware 2.2.0), whose section numbers are given, or else
that of CiA 301. J1..J33 are the decisions in core/src/model/jn2101/README.md: what the sensor does where the manual is unclear or
contradicts itself. The modules `ims360_*` refer to SIKO's user manual of the IMS360 and to the decisions S1..S76 in
core/src/model/ims360/README.md. `cases.md` lists the check for each case of CiA's conformance test.
"""

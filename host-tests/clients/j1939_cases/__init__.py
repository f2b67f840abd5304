"""Black-box checks of the IMS360 as a node of SAE J1939.

The expected behaviour is that of the decisions S17..S39 in core/src/model/ims360/J1939.md, or else that of J1939-21 (transport),
J1939-73 (diagnostics) and J1939-81 (addresses). The parameters are the objects of the CANopen manual.
"""

"""The traces of the IMS360 in J1939 that are about its address."""

from j1939_frames import (
    CLAIM,
    COMMANDED,
    COMPONENT,
    CONTROL,
    DATA,
    DM1,
    EVERYONE,
    HIGHEST,
    J1939Trace,
    LOWEST,
    NOBODY,
    PROPRIETARY,
    QUIET,
    SENSOR,
    SOFTWARE,
    TESTER,
    identifier,
    little,
    packets_of_command,
)


def claim() -> J1939Trace:
    """Claim, contention with higher and lower NAMEs, and the next start."""
    trace = J1939Trace("claim", "J1939-81, 4.2 and 4.4", writes=QUIET)
    trace.note("Within the 250 ms only a request for the claim is answered.")
    trace.group(CLAIM, trace.name_data)
    begin = trace.now
    trace.wait(100)
    trace.request(COMPONENT)
    trace.wait(10)
    trace.request(CLAIM, EVERYONE)
    trace.group(CLAIM, trace.name_data)
    trace.now = begin
    trace.silence()
    trace.wait(100)
    trace.note("A higher NAME at 80h: the address is kept.")
    trace.tell(CLAIM, HIGHEST, source=SENSOR)
    trace.group(CLAIM, trace.name_data)
    trace.wait(10)
    trace.note("The own NAME at 80h is ignored.")
    trace.tell(CLAIM, trace.name_data, source=SENSOR)
    trace.wait(10)
    trace.note("81h and 82h are claimed by others; a lower NAME at 80h: the next address is 83h.")
    for source in (0x81, 0x82):
        trace.tell(CLAIM, HIGHEST, source=source)
        trace.wait(10)
    trace.tell(CLAIM, LOWEST, source=SENSOR)
    trace.address = 0x83
    trace.claims()
    trace.wait(10)
    trace.request(SOFTWARE, 0x80)
    trace.wait(10)
    trace.request(CLAIM, 0x83)
    trace.group(CLAIM, trace.name_data)
    trace.wait(10)
    trace.note("2102h has not changed: the next start claims 80h.")
    trace.parameter("4002210000000000", "4F02210080000000")
    trace.restarts()
    trace.address = SENSOR
    trace.claims()
    return trace


def commanded_address() -> J1939Trace:
    """Commanded Address by BAM and by RTS and CTS."""
    trace = J1939Trace("commanded-address", "J1939-81, 4.5.2, and J1939-21, 5.10", writes=QUIET)
    trace.claims()
    trace.wait(10)
    announced = f"090002FF{little(COMMANDED, 3)}"

    def command(data: str, address: int, *, engine: bool = False) -> None:
        parts = packets_of_command(data, address)
        trace.tell(CONTROL, "20" + announced)
        for number, part in enumerate(parts):
            trace.wait(50)
            trace.tell(DATA, part)
            if engine and number == 0:
                trace.tell(CONTROL, f"200A0002FF{little(DM1, 3)}", source=0)
                trace.tell(DATA, "0104FF7013000171", source=0)

    trace.note("Another NAME, and the addresses 254 and 255: nothing.")
    for data, address in ((HIGHEST, 0xA0), (trace.name_data, 254), (trace.name_data, 255)):
        command(data, address)
        trace.wait(10)
    trace.note("Our NAME and A0h, while an engine sends a message to all.")
    command(trace.name_data, 0xA0, engine=True)
    trace.address = 0xA0
    trace.claims()
    trace.wait(10)
    trace.parameter("4002210000000000", "4F022100A0000000")
    trace.note("To us, one packet for each CTS; 5.")
    first, second = packets_of_command(trace.name_data, 5)
    trace.tell(CONTROL, f"1009000201{little(COMMANDED, 3)}", 0xA0)
    trace.group(CONTROL, f"110101FFFF{little(COMMANDED, 3)}", TESTER)
    trace.wait(10)
    trace.tell(DATA, first, 0xA0)
    trace.group(CONTROL, f"110102FFFF{little(COMMANDED, 3)}", TESTER)
    trace.wait(10)
    trace.tell(DATA, second, 0xA0)
    trace.group(CONTROL, "13" + announced, TESTER)
    trace.address = 5
    trace.claims()
    trace.wait(10)
    trace.note("Without a save, the next start claims the stored address.")
    trace.restarts()
    trace.address = SENSOR
    trace.claims()
    return trace


def cannot_claim() -> J1939Trace:
    """A node that is not arbitrary address capable loses its address."""
    trace = J1939Trace("cannot-claim", "J1939-81, 4.4.4", writes=(*QUIET, "2F06210100000000"))
    trace.claims()
    trace.wait(10)

    def lost() -> None:
        """Cannot claim, 0 to 153 ms later."""
        begin = trace.now
        trace.tolerance(77_500)
        trace.now = begin + 77_000
        trace.expect(identifier(CLAIM, NOBODY), trace.name_data)
        trace.now = begin + 200_000
        trace.tolerance(300)

    trace.tell(CLAIM, LOWEST, source=SENSOR)
    lost()
    trace.note("Requests for the claim are answered, by all and to 254; nothing else is.")
    for destination in (EVERYONE, NOBODY):
        trace.request(CLAIM, destination)
        lost()
    for destination in (EVERYONE, NOBODY, SENSOR):
        trace.request(SOFTWARE, destination)
        trace.wait(10)
        trace.tell(PROPRIETARY, "4000100000000000", destination)
        trace.wait(10)
    trace.wait(1000)
    trace.note("Commanded Address is obeyed.")
    trace.tell(CONTROL, f"20090002FF{little(COMMANDED, 3)}")
    for part in packets_of_command(trace.name_data, 0xA0):
        trace.wait(50)
        trace.tell(DATA, part)
    trace.address = 0xA0
    trace.claims()
    return trace

#!/usr/bin/env python3
"""Runs instructions in Unicorn, an independent emulator of the Cortex-M3 and M4, and compares the results.

    pip install -r requirements.txt
    python thumb_judge.py MODEL SAMPLES

`stm32-sim/tests/chip/thumb` writes the samples with the results of the simulated processor. The exit code is 1 if one differs.
Unicorn is under the GPL: it only runs in this separate process, and no part of the project is linked with it.
"""

import struct
import sys

from unicorn import UC_ARCH_ARM, UC_HOOK_MEM_UNMAPPED, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn import arm_const as arm

FLASH, FLASH_SIZE = 0x0800_0000, 0x1_0000
RAM, RAM_SIZE = 0x2000_0000, 0x5000
CODE, CODE_SIZE = 0x400, 0x80
REGISTERS = [
    *(getattr(arm, f"UC_ARM_REG_R{n}") for n in range(13)),
    arm.UC_ARM_REG_SP,
    arm.UC_ARM_REG_LR,
    arm.UC_ARM_REG_PC,
]
STATE = struct.Struct("<17I")
RUNS, REFUSED = 0, 1
# N, Z, C, V, Q; and GE, which is always 0 on the Cortex-M3. ITSTATE is always 0 between samples.
FLAGS = 0xF80F_0000
MODELS = {"m3": arm.UC_CPU_ARM_CORTEX_M3, "m4": arm.UC_CPU_ARM_CORTEX_M4}
MOST_REPORTS = 20
# Bits of RAM as words (STM32F10xxx programming manual PM0056, 2.2.5).
BIT_BAND = range(0x2200_0000, 0x2400_0000)
SKIPPED = "skipped"


class Reader:
    """Reads the fields of a file."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, size: int) -> bytes:
        self.at += size
        return self.data[self.at - size : self.at]

    def state(self) -> tuple[int, ...]:
        return STATE.unpack(self.take(STATE.size))


def machine(model: int) -> Uc:
    """An emulator with the same memory map: flash, also at 0, and RAM."""
    uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
    uc.ctl_set_cpu_model(model)
    for start in (0, FLASH):
        uc.mem_map(start, FLASH_SIZE)
        uc.mem_write(start, b"\xff" * FLASH_SIZE)
    uc.mem_map(RAM, RAM_SIZE)
    uc.hook_add(UC_HOOK_MEM_UNMAPPED, unmapped)
    return uc


def unmapped(_uc: Uc, _access: int, address: int, _size: int, _value: int, _data: object) -> bool:
    """Records the address; the access fails."""
    missing.append(address)
    return False


missing: list[int] = []


def prepare(uc: Uc, code: bytes, before: tuple[int, ...], ram: bytes) -> None:
    """Sets memory and registers to the state before the sample."""
    for start in (0, FLASH):
        uc.mem_write(start + CODE, code.ljust(CODE_SIZE, b"\xff"))
    uc.ctl_remove_cache(FLASH + CODE, FLASH + CODE + CODE_SIZE)
    uc.mem_write(RAM, ram)
    for register, value in zip(REGISTERS, before):
        uc.reg_write(register, value)
    uc.reg_write(arm.UC_ARM_REG_APSR_NZCVQG, before[16] & FLAGS)


def differences(uc: Uc, after: tuple[int, ...], ram: bytes) -> list[str]:
    """The differences from the expected state."""
    found = [uc.reg_read(register) for register in REGISTERS]
    wrong = [f"r{n} {ours:#x}, unicorn {its:#x}" for n, (ours, its) in enumerate(zip(after, found)) if ours != its]
    flags = uc.reg_read(arm.UC_ARM_REG_XPSR) & FLAGS
    if flags != after[16] & FLAGS:
        wrong.append(f"flags {after[16] & FLAGS:#x}, unicorn {flags:#x}")
    memory = bytes(uc.mem_read(RAM, RAM_SIZE))
    wrong += [f"[{RAM + n:#x}] {ram[n]:#x}, unicorn {memory[n]:#x}" for n in range(RAM_SIZE) if ram[n] != memory[n]] if memory != ram else []
    return wrong


def judge(uc: Uc, reader: Reader, ram: bytes) -> str:
    """Runs one sample; returns the difference, or an empty text."""
    verdict, count, size = struct.unpack("<BBB", reader.take(3))
    code = reader.take(size)
    before, after = reader.state(), reader.state()
    changed = bytearray(ram)
    (changes,) = struct.unpack("<H", reader.take(2))
    for _ in range(changes):
        offset, value = struct.unpack("<HB", reader.take(3))
        changed[offset] = value
    prepare(uc, code, before, ram)
    refused = ""
    missing.clear()
    try:
        uc.emu_start(before[15] | 1, 0xFFFF_FFFE if count else FLASH + CODE + size, count=count)
    except UcError as error:
        refused = str(error)
    if verdict == REFUSED:
        return "" if refused else "unicorn does not refuse it"
    if missing and missing[0] in BIT_BAND:
        return SKIPPED
    # A branch may have any target: it has been executed if the fetch from the target fails.
    if refused and missing != [after[15]]:
        return f"unicorn refuses it: {refused}"
    return "; ".join(differences(uc, after, bytes(changed)))


def main() -> int:
    """Runs all samples; returns the exit code."""
    model, path = sys.argv[1:]
    with open(path, "rb") as file:
        reader = Reader(file.read())
    ram = reader.take(RAM_SIZE)
    uc = machine(MODELS[model])
    samples = skipped = failed = 0
    while reader.at < len(reader.data):
        start = reader.at
        wrong = judge(uc, reader, ram)
        samples += 1
        if wrong == SKIPPED:
            skipped += 1
            # The access that failed can leave an IT block open.
            uc = machine(MODELS[model])
        elif wrong:
            failed += 1
            if failed <= MOST_REPORTS:
                size = reader.data[start + 2]
                words = struct.unpack(f"<{size // 2}H", reader.data[start + 3 : start + 3 + size])
                print("FAILED", " ".join(f"{word:04x}" for word in words), wrong)
    print(f"{samples} samples, {skipped} skipped, {failed} failed")
    return int(failed > 0 or samples == 0 or skipped > samples // 100)


if __name__ == "__main__":
    sys.exit(main())

"""Folders of binaries in an FMU, and macOS libraries for several architectures."""

from __future__ import annotations

import struct
from collections.abc import Sequence


def binary_folder(fmi: str, platform: str, platforms: Sequence[str]) -> str:
    """Folder of the library of a platform inside the FMU.

    FMI 2.0 has one folder for 64-bit Linux and one for macOS. The first holds x86_64 if that is among the platforms,
    the second both architectures (see `universal`).
    """
    architecture, system = platform.split("-")
    if fmi == "3.0":
        return f"{architecture}-{'darwin' if system == 'macos' else system}"
    if system == "linux" and architecture == "aarch64" and "x86_64-linux" in platforms:
        return platform
    bits = 32 if architecture == "x86" else 64
    return {"linux": "linux", "windows": "win", "macos": "darwin"}[system] + str(bits)


_MACHO = {"x86_64": (0x01000007, 3), "aarch64": (0x0100000C, 0)}  # CPU type and subtype
_ALIGNMENT = 14  # bits: page size of Apple's processors


def universal(slices: dict[str, bytes]) -> bytes:
    """A macOS library for several architectures, from one library for each."""
    head = struct.pack(">II", 0xCAFEBABE, len(slices))
    body, table, place = b"", b"", 1 << _ALIGNMENT
    for architecture, data in slices.items():
        cpu, subtype = _MACHO[architecture]
        table += struct.pack(">IIIII", cpu, subtype, place + len(body), len(data), _ALIGNMENT)
        body += data + b"\0" * (-len(data) % (1 << _ALIGNMENT))
    return (head + table).ljust(place, b"\0") + body

"""End-to-end protection, independent of the program's: CRCs by crcmod, layouts and Data IDs as the specifications say.

AUTOSAR FO PRS E2EProtocol (profiles 1 and 11), SAE J1850 (CRC-8), SAE J1939-71 (SPN 4206 and 4207, of TSC1)."""

from dataclasses import dataclass

import crcmod

POLYNOMIAL = 0x11D  # x⁸ + x⁴ + x³ + x² + 1
crc8_j1850 = crcmod.mkCrcFun(POLYNOMIAL, initCrc=0x00, rev=False, xorOut=0xFF)  # starts with initCrc ^ xorOut
crc8_autosar = crcmod.mkCrcFun(POLYNOMIAL, initCrc=0x00, rev=False, xorOut=0x00)  # of both profiles


@dataclass(frozen=True)
class Profile:
    """A protected frame. Where its counter and checksum lie: byte, low bit; in J1939 both have four bits."""

    name: str
    round: int
    data_id: int = None
    mode: str = "both"
    counter: tuple = (1, 0)
    checksum: tuple = (0, 0)

    def data_id_bytes(self, count):
        low, high = self.data_id & 0xFF, self.data_id >> 8
        return bytes({"both": [low, high], "alt": [high if count % 2 else low], "low": [low],
                      "nibble": [low, 0]}[self.mode])

    def protect(self, can_id, count, data):
        """@param data  its counter and checksum are whatever @return the frame's data"""
        data = bytearray(data)
        put(data, self.counter, 4, count)
        if self.name == "j1939_counter_checksum":
            put(data, self.checksum, 4, 0)
            payload = bytearray(data)
            put(payload, self.counter, 4, 0)
            total = sum(payload) + count + sum(can_id.to_bytes(4, "big"))
            put(data, self.checksum, 4, (((total >> 6) & 3) + (total >> 3) + total) & 7)
            return bytes(data)
        if self.mode == "nibble":
            put(data, (self.counter[0], 4 - self.counter[1]), 4, self.data_id >> 8)
        place = self.checksum[0]
        covered = bytes(data[:place] + data[place + 1:])
        if self.name == "crc8_j1850":
            data[place] = crc8_j1850((b"" if self.data_id is None else self.data_id_bytes(count)) + covered)
        elif self.name != "counter":
            data[place] = crc8_autosar(self.data_id_bytes(count) + covered)
        return bytes(data)


def put(data, place, bits, value):
    byte, low = place
    mask = (1 << bits) - 1 << low
    data[byte] = data[byte] & ~mask | value << low & mask

"""Reads saved maps (docs/formats.md). Needs NumPy."""

import struct

import numpy

HEADER, SECTION, CAMERA, VIEW = 32, 12, 177, 100  # [bytes]


class SavedMap:
    """Positions p [n, 3], own covariances D [n, 3, 3], shared errors U [n, 3, r], and of each landmark `looks`: its
    first descriptors, which stay the same when maps are merged."""

    def __init__(self, file):
        self.data, self.at = file.read_bytes(), HEADER
        for _ in range(self.take("<I")):  # sessions
            self.skip(self.take("<I") + 16)
            self.skip(CAMERA * self.take("<I"))
        self.p, self.D, self.appearances = [], [], []
        for _ in range(self.take("<I")):
            self.p.append(self.take("<3d"))
            self.skip(8)
            xx, yx, yy, zx, zy, zz = self.take("<6f")
            self.D.append([[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]])
            views = self.take("<B")
            self.appearances.append(self.data[self.at + 4:self.at + VIEW])
            self.skip(VIEW * views)
        self.p, self.D = numpy.array(self.p), numpy.array(self.D)
        r = self.take("<I")
        old = self.data[16] == 1
        self.U = numpy.frombuffer(self.data, "<f4" if old else "<f2", 3 * r * len(self.p), self.at)
        self.skip(self.U.nbytes)
        self.U = self.U.reshape(len(self.p), 3, r).astype(float)
        if not old:  # the maps of which it was merged
            self.skip(SECTION + int.from_bytes(self.data[self.at + 4:self.at + SECTION], "little"))
        if self.at != len(self.data):
            raise SystemExit(f"{file}: {len(self.data) - self.at} bytes are left")

    def skip(self, count):
        self.at += count

    def take(self, kind):
        values = struct.unpack_from(kind, self.data, self.at)
        self.at += struct.calcsize(kind)
        return values[0] if len(values) == 1 else values

    def covariances(self):
        return self.D + self.U @ self.U.transpose(0, 2, 1)

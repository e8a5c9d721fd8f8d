"""The truth of a rendered block of corridors: the points that a run has seen, whether the landmarks that returned are
the ones that were seen before, and which part of the revisits is recognised. Needs NumPy."""

import json

import numpy

CAMERA_IN_IMU = numpy.array([0.05, 0.02, 0.03])
AXES = numpy.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])  # of the camera, in the IMU's
WIDTH, FLOOR, CEILING = 3, -1.2, 1.6  # [m]
DEFAULTS = {"hall_length": 30, "hall_width": 12, "focal_length": 480, "center_u": 349.5, "center_v": 270}
# A pose of a revisit is so near to one of so long before.
NEAR, HEADING, BEFORE = 1.0, numpy.radians(30), 20  # [m], [rad], [s]
PIECE, AHEAD = 2, 5  # [s]


def rotations(q):
    x, y, z, w = q.T
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]).transpose(2, 0, 1)


class Block:
    """A run with `--keep-images 1` of a recording of the scene hallway with these settings."""

    def __init__(self, run, settings):
        self.settings = DEFAULTS | settings
        names = (run / "features.csv").open().readline().strip().split(",")
        rows = numpy.genfromtxt(run / "features.csv", delimiter=",", skip_header=1,
                                usecols=[names.index(name) for name in ("landmark", "time_ns", "u", "v")])
        rows = rows[numpy.argsort(rows[:, 0], kind="stable")]
        tracks, begins = numpy.unique(rows[:, 0], return_index=True)
        self.tracks = dict(zip(tracks.astype(int).tolist(), numpy.split(rows[:, 1:], begins[1:])))
        self.truth = numpy.loadtxt(run / "truth.tum")
        self.R = rotations(self.truth[:, 4:8])
        # The corridors' centre lines; the walker sways by 2 cm, evenly.
        self.centre = (self.truth[:, 1:3].min(0) + self.truth[:, 1:3].max(0)) / 2
        self.half = numpy.array([self.settings["hall_length"], self.settings["hall_width"]]) / 2

    def hit(self, origin, ray):
        """Where a ray meets floor, ceiling, an outer wall or the block within, and how far away."""
        near = min(t for t in ((FLOOR - origin[2]) / ray[2], (CEILING - origin[2]) / ray[2]) if t > 0)
        for edge in (self.half + WIDTH / 2, self.half - WIDTH / 2):
            for axis in (0, 1):
                for side in (-1, 1):
                    t = (self.centre[axis] + side * edge[axis] - origin[axis]) / ray[axis]
                    across = origin[1 - axis] + t * ray[1 - axis] - self.centre[1 - axis]
                    if 0 < t < near and abs(across) <= edge[1 - axis]:
                        near = t
        return near, origin + near * ray

    def point(self, track):
        """The true point of a track, from its nearest view."""
        views = []
        for time, u, v in self.tracks[track]:
            i = int(numpy.argmin(abs(1e9 * self.truth[:, 0] - time)))
            ray = numpy.array([(u - self.settings["center_u"]) / self.settings["focal_length"],
                               (v - self.settings["center_v"]) / self.settings["focal_length"], 1])
            views.append(self.hit(self.truth[i, 1:4] + self.R[i] @ CAMERA_IN_IMU, self.R[i] @ AXES @ ray))
        return min(views, key=lambda view: view[0])[1]


class Revisits(Block):
    def __init__(self, run, settings):
        super().__init__(run, settings)
        summary = json.loads((run / "summary.json").read_text())
        self.recognised = summary["recognised_tracks"]
        self.closures = [1e-9 * closure["time_ns"] for closure in summary["closures"]]
        self.searches = 1e-9 * numpy.array(summary["recognised_ns"])  # that found past landmarks
        self.returned = sum(closure["landmarks"] for closure in summary["closures"])

    def distances(self):
        """Between the true points of what was taken for one landmark [m]."""
        return [numpy.linalg.norm(self.point(track) - self.point(landmark)) for track, landmark in self.recognised]

    def times(self):
        """When a recognised landmark is in view [s]: of each track from the closure on that recognised it."""
        times = []
        for track, _ in self.recognised:
            seen = 1e-9 * self.tracks[track][:, 0]
            closure = min((c for c in self.closures if c > seen[0]), default=numpy.inf)
            times.extend(seen[seen > closure - 1e-3])
        return numpy.array(times)

    def recall(self):
        """Of the revisits, two figures for recognition and for the return of landmarks: seconds from the beginning of the
        first one, and of each piece of PIECE seconds, whether a search found landmarks, and one that returned is in view."""
        t, p, forward, seen = self.truth[:, 0], self.truth[:, 1:4], self.R[:, :, 0], self.times()
        again = numpy.array([((t <= s - BEFORE) & (numpy.linalg.norm(p - at, axis=1) < NEAR) &
                              (forward @ to > numpy.cos(HEADING))).any() for s, at, to in zip(t, p, forward)])
        begin = t[numpy.argmax(again)]
        pieces = [s for s in numpy.arange(begin, t[-1] - PIECE, PIECE) if again[(t >= s) & (t < s + PIECE)].all()]

        # The camera sees a place before it is there. Earlier times are of what was lost from view for a while.
        def first(times):
            return min((time for time in times if time > begin - AHEAD), default=numpy.inf) - begin

        def within(times):
            return [bool(((times >= s) & (times < s + PIECE)).any()) for s in pieces]

        return {"found": (first(self.searches), within(self.searches)), "back": (first(self.closures), within(seen))}

#!/usr/bin/env python3
"""compare.py FIGURES OTHERS MOST [NAME=MOST...]: compares what figures.cpp printed on two machines. Prints,
for each name, the largest difference relative to the largest number of its line; fails if one exceeds
MOST, or that of its name."""
import math
import sys


def lines(file):
    with open(file, encoding="ascii") as stream:
        return [(line.split()[0], [float(word) for word in line.split()[1:]]) for line in stream]


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    ours, theirs, most = lines(sys.argv[1]), lines(sys.argv[2]), float(sys.argv[3])
    most_of = {name: float(value) for name, value in (word.split("=") for word in sys.argv[4:])}
    if not ours or [line[0] for line in ours] != [line[0] for line in theirs]:
        sys.exit(f"compare.py: {sys.argv[1]} and {sys.argv[2]} have other lines, expected the same names")
    largest = {}
    for (name, a), (_, b) in zip(ours, theirs):
        if len(a) != len(b):
            sys.exit(f"compare.py: {name} has {len(a)} and {len(b)} numbers, expected as many")
        scale = max(map(abs, a)) or 1
        differences = [abs(x - y) / scale for x, y in zip(a, b)]
        difference = max(differences) if all(map(math.isfinite, differences)) else math.inf
        largest[name] = max(largest.get(name, 0), difference)
    for name, difference in largest.items():
        print(f"  {name:<32} {difference:.1e}")
    for name, difference in largest.items():
        limit = most_of.get(name, most)
        if difference > limit:
            sys.exit(f"compare.py: {name}: found a relative difference of {difference:.1e}, expected at most "
                     f"{limit:.0e}")


if __name__ == "__main__":
    main()

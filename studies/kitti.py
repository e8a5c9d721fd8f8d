"""The KITTI tracks: recordings, truth and drives."""

import pathlib
import typing

from studies.program import DATA, Arguments

KITTI = DATA / "kitti_tracks"
# The ECE276A archives contain no truth; the .mat files do.
TRUTH = {
    "ece276a_2018/0020": "0020_gt_imu_stars.tum",
    "ece276a_2018/0027": "0027_gt_imu_stars.tum",
    "ece276a_2018/0042": "0042_gt_imu_stars.tum",
    "ece276a_2020/0022": "0022_pseudogt_orbslam3_imu.tum",
    "ece276a_2020/0027": "0027_gt_imu_stars.tum",
}
# Recordings of the same drive: 15 recordings show 12 drives. Tests of significance count a drive once.
DRIVE = {
    "ece276a_2018/0027": "2011_09_30_drive_0027",
    "ece276a_2020/0027": "2011_09_30_drive_0027",
    "stars/2011_09_30_drive_0027": "2011_09_30_drive_0027",
    "ece276a_2018/0042": "2011_10_03_drive_0042",
    "stars/2011_10_03_drive_0042": "2011_10_03_drive_0042",
}
STALE_CUT, EXTRINSICS_REPAIRED = ["--set", "reader.stale_pixels=cut"], ["--set", "reader.extrinsics=auto"]
REPAIRED = [*STALE_CUT, *EXTRINSICS_REPAIRED]


def short_name(name: str) -> str:
    return name.replace("_sync_KLT", "")


def recordings() -> dict[str, pathlib.Path]:
    files = sorted(KITTI.glob("ece276a_*/*.npz")) + sorted(KITTI.glob("stars/*.mat"))
    return {f"{file.parent.name}/{file.stem}": file for file in files}


def truth_of(name: str) -> Arguments:
    """Arguments of `run`: the truth of a recording that contains none."""
    return ["--truth", KITTI / "ground_truth" / TRUTH[name]] if name in TRUTH else []


def drives() -> typing.Iterator[tuple[str, Arguments]]:
    """Name and arguments of `run`."""
    for name, file in recordings().items():
        yield short_name(name), [file, *truth_of(name)]

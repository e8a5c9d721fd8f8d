#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/recording/georeference.hpp>

namespace chasles {

// The folder oxts/ of a KITTI raw recording (Geiger et al. 2013): timestamps.txt with one line per
// packet, data/NNNNNNNNNN.txt with thirty numbers each. Errors are InputError with file and line.

/// A line of timestamps.txt.
struct KittiStamp {
  std::size_t index = 0;  ///< number of the line from 0, which is that of its file in data/
  Time time{};            ///< since 1970 (UTC)
};

/// One time per line, "2011-09-26 13:02:25.964389445". A line that is empty stands for a file that
/// was lost; the numbers of the later ones count it. Empty lines at the end do not count.
std::vector<KittiStamp> read_kitti_times(const std::filesystem::path& file);

/// One packet of the GNSS/INS.
struct OxtsPacket {
  ImuSample sample;  ///< body axes: x forward, y left, z up
  Geodetic place;
  double roll = 0, pitch = 0, yaw = 0;  ///< world_R_imu = Rz(yaw) Ry(pitch) Rx(roll)
};

/// All packets, in the order of their files.
std::vector<OxtsPacket> read_oxts(const std::filesystem::path& folder);

/// world_T_imu in KITTI's convention: the Mercator projection at the first packet's latitude. x
/// points east, y north, z up; the first position is the origin.
Trajectory oxts_trajectory(const std::vector<OxtsPacket>& packets);

/// The georeference of that world. Presumes at least one packet.
Georeference oxts_georeference(const std::vector<OxtsPacket>& packets);

}  // namespace chasles

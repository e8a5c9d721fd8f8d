#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>

namespace chasles {

/// A truth as its file has it.
struct TruthTable {
  Trajectory poses;       ///< world_T_imu; without attitudes every rotation is the identity
  bool attitudes = true;  ///< false: positions alone
  Eigen::Vector3d point_imu = Eigen::Vector3d::Zero();  ///< of these positions, in IMU axes [m]
};

/// read_tum() for a truth, which may have positions alone: lines `t x y z`, tables that name no
/// quaternion as EuRoC's leica0, and quaternions that are all zero. The prism of leica0 is where
/// T_BS in sensor.yaml beside the table has it.
TruthTable read_truth_table(const std::filesystem::path& file, std::vector<std::string>& remarks);

/// The same as the truth of a recording, with remarks there.
void read_truth_of_recording(const std::filesystem::path& file, Recording& recording);

/// The poses of a bag of ROS 1 or 2, by their header stamps: geometry_msgs/PoseStamped,
/// PoseWithCovarianceStamped, TransformStamped or PointStamped (positions alone),
/// nav_msgs/Odometry, or tf2_msgs/TFMessage. `topic`: its name, of a TFMessage also
/// "TOPIC:CHILD_FRAME"; empty: the only one, TFMessages last. A remark names topic, type and
/// frames. Throws InputError with the topics of poses where the choice is open, and where there is
/// none.
TruthTable read_bag_truth(const std::filesystem::path& bag, const std::string& topic,
                          std::vector<std::string>& remarks);

/// Whether a path is a bag: a file by its first bytes, or a folder with bags.
bool is_bag(const std::filesystem::path& path);

}  // namespace chasles

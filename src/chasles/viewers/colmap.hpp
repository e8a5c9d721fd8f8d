#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// Where an image shows a point of the model.
struct ColmapObservation {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px]
  std::size_t point = 0;                            ///< in ColmapModel::points
};

/// An image of a camera of the rig.
struct ColmapImage {
  std::size_t camera = 0;  ///< in ColmapModel::cameras
  std::string name;        ///< of its file, from the folder of all images
  std::vector<ColmapObservation> observations = {};
};

/// The images of the rig at one instant, one of each camera that has one.
struct ColmapFrame {
  SE3 world_T_imu;
  Matrix6d pose_covariance = Matrix6d::Zero();  ///< as RunState has it
  std::vector<ColmapImage> images = {};
};

/// A point of the model. Its track are the observations of it.
struct ColmapPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]
  double error = 0;       ///< mean length of its reprojection errors [px]
  std::uint8_t grey = 0;  ///< of its observations
};

/// What COLMAP calls a reconstruction, in the conventions of this project. The first camera is the
/// one that COLMAP's rig has for its origin.
struct ColmapModel {
  std::vector<Camera> cameras;
  std::vector<ColmapFrame> frames = {};
  std::vector<ColmapPoint> points = {};
  bool is_level = false;  ///< gravity is along -z of the world
};

/// Names and contents of files.
using ColmapFiles = std::vector<std::pair<std::string, std::string>>;

/// cameras, images, points3D, rigs and frames, as .bin or .txt of COLMAP 3.12 or later; earlier
/// ones read the first three. Poses are world to camera, and the first pixel's centre is
/// (0.5, 0.5). Ids count from 1, images by frame and then by camera. Throws InputError for a lens
/// that COLMAP does not have, and in text for a space in the name of an image.
ColmapFiles colmap_binary(const ColmapModel& model);
ColmapFiles colmap_text(const ColmapModel& model);

/// database.db of COLMAP 4.2: cameras, rig, frames and images with the ids of the model, and a pose
/// prior of each image: the position of its camera with covariance and, if the model is level, the
/// direction of gravity. Features and matches are COLMAP's to add.
std::string colmap_database(const ColmapModel& model);

}  // namespace chasles

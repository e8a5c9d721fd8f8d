#pragma once

#include <string>

namespace chasles {

/// A topic and the schema of its messages.
struct ViewerTopic {
  std::string topic, schema;
};

// The topics of a run, in files and live (docs/formats.md).
inline const ViewerTopic kTfTopic{"/tf", "foxglove.FrameTransforms"};
inline const ViewerTopic kTfCamerasTopic{"/tf_cameras", "foxglove.FrameTransforms"};
inline const ViewerTopic kTfMapTopic{"/tf_map", "foxglove.FrameTransforms"};
inline const ViewerTopic kPoseTopic{"/pose", "foxglove.PoseInFrame"};
inline const ViewerTopic kOdometryTopic{"/odometry", "foxglove.Odometry"};
inline const ViewerTopic kStateTopic{"/state", "chasles.State"};
inline const ViewerTopic kErrorsTopic{"/errors", "chasles.Errors"};
inline const ViewerTopic kTruthTopic{"/truth/pose", "foxglove.PoseInFrame"};
inline const ViewerTopic kWaysTopic{"/ways", "foxglove.SceneUpdate"};
inline const ViewerTopic kMapTopic{"/map", "foxglove.PointCloud"};
inline const ViewerTopic kEllipsoidsTopic{"/map/ellipsoids", "foxglove.SceneUpdate"};
inline const ViewerTopic kPriorMapTopic{"/map/prior", "foxglove.PointCloud"};
inline const ViewerTopic kClosuresTopic{"/closures", "foxglove.SceneUpdate"};
inline const ViewerTopic kLocationTopic{"/location", "foxglove.LocationFix"};
inline ViewerTopic image_topic(int camera) {
  return {"/cam" + std::to_string(camera) + "/image", "foxglove.CompressedImage"};
}
inline ViewerTopic annotations_topic(int camera) {
  return {"/cam" + std::to_string(camera) + "/annotations", "foxglove.ImageAnnotations"};
}

}  // namespace chasles

#include <nlohmann/json.hpp>

#include <chasles/codec/numbers.hpp>
#include <chasles/viewers/foxglove.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

std::vector<ProtoMessage> elements() {
  return {
      proto_message("google.protobuf.Timestamp", {"int64 seconds = 1", "int32 nanos = 2"}),
      proto_message("google.protobuf.Duration", {"int64 seconds = 1", "int32 nanos = 2"}),
      proto_message("foxglove.Vector3", {"double x = 1", "double y = 2", "double z = 3"}),
      proto_message("foxglove.Point3", {"double x = 1", "double y = 2", "double z = 3"}),
      proto_message("foxglove.Point2", {"double x = 1", "double y = 2"}),
      proto_message("foxglove.Quaternion",
                    {"double x = 1", "double y = 2", "double z = 3", "double w = 4"}),
      proto_message("foxglove.Pose",
                    {"foxglove.Vector3 position = 1", "foxglove.Quaternion orientation = 2"}),
      proto_message("foxglove.Color",
                    {"double r = 1", "double g = 2", "double b = 3", "double a = 4"}),
      proto_message("foxglove.KeyValuePair", {"string key = 1", "string value = 2"}),
  };
}

std::vector<ProtoMessage> motions() {
  return {
      proto_message("foxglove.FrameTransform",
                    {"google.protobuf.Timestamp timestamp = 1", "string parent_frame_id = 2",
                     "string child_frame_id = 3", "foxglove.Vector3 translation = 4",
                     "foxglove.Quaternion rotation = 5"}),
      proto_message("foxglove.FrameTransforms",
                    {"repeated foxglove.FrameTransform transforms = 1"}),
      proto_message("foxglove.PoseInFrame", {"google.protobuf.Timestamp timestamp = 1",
                                             "string frame_id = 2", "foxglove.Pose pose = 3"}),
      proto_message("foxglove.PosesInFrame",
                    {"google.protobuf.Timestamp timestamp = 1", "string frame_id = 2",
                     "repeated foxglove.Pose poses = 3"}),
      proto_message(
          "foxglove.Odometry",
          {"google.protobuf.Timestamp timestamp = 1", "string frame_id = 2",
           "string body_frame_id = 3", "foxglove.Pose pose = 4",
           "foxglove.Vector3 linear_velocity = 5", "foxglove.Vector3 angular_velocity = 6",
           "repeated double pose_covariance = 7", "repeated double velocity_covariance = 8",
           "repeated foxglove.KeyValuePair metadata = 9"}),
      proto_message(
          "foxglove.LocationFix",
          {"google.protobuf.Timestamp timestamp = 6", "string frame_id = 7", "double latitude = 1",
           "double longitude = 2", "double altitude = 3", "repeated double position_covariance = 4",
           "PositionCovarianceType position_covariance_type = 5", "double heading = 10",
           "foxglove.Vector3 velocity = 11", "foxglove.Color color = 8",
           "repeated foxglove.KeyValuePair metadata = 9"},
          {{"PositionCovarianceType", {"UNKNOWN", "APPROXIMATED", "DIAGONAL_KNOWN", "KNOWN"}}}),
  };
}

// A viewer reads every list of an entity, so all of them are declared.
std::vector<ProtoMessage> primitives() {
  return {
      proto_message(
          "foxglove.ArrowPrimitive",
          {"foxglove.Pose pose = 1", "double shaft_length = 2", "double shaft_diameter = 3",
           "double head_length = 4", "double head_diameter = 5", "foxglove.Color color = 6"}),
      proto_message(
          "foxglove.CubePrimitive",
          {"foxglove.Pose pose = 1", "foxglove.Vector3 size = 2", "foxglove.Color color = 3"}),
      proto_message(
          "foxglove.SpherePrimitive",
          {"foxglove.Pose pose = 1", "foxglove.Vector3 size = 2", "foxglove.Color color = 3"}),
      proto_message(
          "foxglove.CylinderPrimitive",
          {"foxglove.Pose pose = 1", "foxglove.Vector3 size = 2", "double bottom_scale = 3",
           "double top_scale = 4", "foxglove.Color color = 5"}),
      proto_message("foxglove.LinePrimitive",
                    {"Type type = 1", "foxglove.Pose pose = 2", "double thickness = 3",
                     "bool scale_invariant = 4", "repeated foxglove.Point3 points = 5",
                     "foxglove.Color color = 6", "repeated foxglove.Color colors = 7",
                     "repeated fixed32 indices = 8"},
                    {{"Type", {"LINE_STRIP", "LINE_LOOP", "LINE_LIST"}}}),
      proto_message("foxglove.TriangleListPrimitive",
                    {"foxglove.Pose pose = 1", "repeated foxglove.Point3 points = 2",
                     "foxglove.Color color = 3", "repeated foxglove.Color colors = 4",
                     "repeated fixed32 indices = 5"}),
      proto_message("foxglove.TextPrimitive",
                    {"foxglove.Pose pose = 1", "bool billboard = 2", "double font_size = 3",
                     "bool scale_invariant = 4", "foxglove.Color color = 5", "string text = 6"}),
      proto_message(
          "foxglove.ModelPrimitive",
          {"foxglove.Pose pose = 1", "foxglove.Vector3 scale = 2", "foxglove.Color color = 3",
           "bool override_color = 4", "string url = 5", "string media_type = 6", "bytes data = 7"}),
  };
}

std::vector<ProtoMessage> scenes() {
  return {
      proto_message("foxglove.SceneEntity",
                    {"google.protobuf.Timestamp timestamp = 1", "string frame_id = 2",
                     "string id = 3", "google.protobuf.Duration lifetime = 4",
                     "bool frame_locked = 5", "repeated foxglove.KeyValuePair metadata = 6",
                     "repeated foxglove.ArrowPrimitive arrows = 7",
                     "repeated foxglove.CubePrimitive cubes = 8",
                     "repeated foxglove.SpherePrimitive spheres = 9",
                     "repeated foxglove.CylinderPrimitive cylinders = 10",
                     "repeated foxglove.LinePrimitive lines = 11",
                     "repeated foxglove.TriangleListPrimitive triangles = 12",
                     "repeated foxglove.TextPrimitive texts = 13",
                     "repeated foxglove.ModelPrimitive models = 14"}),
      proto_message("foxglove.SceneEntityDeletion",
                    {"google.protobuf.Timestamp timestamp = 1", "Type type = 2", "string id = 3"},
                    {{"Type", {"MATCHING_ID", "ALL"}}}),
      proto_message("foxglove.SceneUpdate", {"repeated foxglove.SceneEntityDeletion deletions = 1",
                                             "repeated foxglove.SceneEntity entities = 2"}),
      proto_message("foxglove.PackedElementField",
                    {"string name = 1", "fixed32 offset = 2", "NumericType type = 3"},
                    {{"NumericType",
                      {"UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32",
                       "FLOAT64"}}}),
      proto_message("foxglove.PointCloud",
                    {"google.protobuf.Timestamp timestamp = 1", "string frame_id = 2",
                     "foxglove.Pose pose = 3", "fixed32 point_stride = 4",
                     "repeated foxglove.PackedElementField fields = 5", "bytes data = 6"}),
  };
}

std::vector<ProtoMessage> images() {
  return {
      proto_message("foxglove.CompressedImage",
                    {"google.protobuf.Timestamp timestamp = 1", "string frame_id = 4",
                     "bytes data = 2", "string format = 3"}),
      proto_message(
          "foxglove.CircleAnnotation",
          {"google.protobuf.Timestamp timestamp = 1", "foxglove.Point2 position = 2",
           "double diameter = 3", "double thickness = 4", "foxglove.Color fill_color = 5",
           "foxglove.Color outline_color = 6", "repeated foxglove.KeyValuePair metadata = 7"}),
      proto_message("foxglove.PointsAnnotation",
                    {"google.protobuf.Timestamp timestamp = 1", "Type type = 2",
                     "repeated foxglove.Point2 points = 3", "foxglove.Color outline_color = 4",
                     "repeated foxglove.Color outline_colors = 5", "foxglove.Color fill_color = 6",
                     "double thickness = 7", "repeated foxglove.KeyValuePair metadata = 8"},
                    {{"Type", {"UNKNOWN", "POINTS", "LINE_LOOP", "LINE_STRIP", "LINE_LIST"}}}),
      proto_message(
          "foxglove.TextAnnotation",
          {"google.protobuf.Timestamp timestamp = 1", "foxglove.Point2 position = 2",
           "string text = 3", "double font_size = 4", "foxglove.Color text_color = 5",
           "foxglove.Color background_color = 6", "repeated foxglove.KeyValuePair metadata = 7"}),
      proto_message("foxglove.ImageAnnotations", {"google.protobuf.Timestamp timestamp = 5",
                                                  "repeated foxglove.CircleAnnotation circles = 1",
                                                  "repeated foxglove.PointsAnnotation points = 2",
                                                  "repeated foxglove.TextAnnotation texts = 3",
                                                  "repeated foxglove.KeyValuePair metadata = 4"}),
  };
}

}  // namespace

const ProtoSchemas& foxglove_schemas() {
  static const ProtoSchemas all = [] {
    ProtoSchemas schemas;
    for (const auto& list : {elements(), motions(), primitives(), scenes(), images()}) {
      for (const ProtoMessage& message : list) schemas.emplace(message.name, message);
    }
    return schemas;
  }();
  return all;
}

Json proto_time(Time time) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(time);
  return {{"seconds", whole.count()}, {"nanos", (time - whole).count()}};
}

Json proto_vector(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

Json proto_rotation(const Eigen::Matrix3d& R) {
  const Eigen::Vector4d q = unit_quaternion(R);
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}

Json proto_pose(const SE3& pose) {
  return {{"position", proto_vector(pose.p)}, {"orientation", proto_rotation(pose.R)}};
}

Json proto_transform(Time time, const std::string& parent, const std::string& child,
                     const SE3& pose) {
  return {{"timestamp", proto_time(time)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", proto_vector(pose.p)},
          {"rotation", proto_rotation(pose.R)}};
}

Json proto_colour(unsigned rgb, double opacity) {
  const auto part = [rgb](unsigned shift) { return (rgb >> shift & 0xff) / 255.0; };
  return {{"r", part(16)}, {"g", part(8)}, {"b", part(0)}, {"a", opacity}};
}

}  // namespace chasles

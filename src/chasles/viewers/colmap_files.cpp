#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/colmap_lens.hpp>
#include <chasles/calibration/image_corner.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/colmap_rig.hpp>

namespace chasles {
namespace {

// An observation of a point: which image, and which of its observations.
struct TrackElement {
  std::uint32_t image = 0, observation = 0;
};

struct Counts {
  std::uint64_t images = 0, observations = 0;
};

Counts counts_of(const ColmapModel& model) {
  Counts counts;
  for (const ColmapFrame& frame : model.frames) {
    counts.images += frame.images.size();
    for (const ColmapImage& image : frame.images) counts.observations += image.observations.size();
  }
  return counts;
}

// Calls visit(frame, image, id) for every image.
template <typename Visit>
void for_each_image(const ColmapModel& model, const Visit& visit) {
  std::size_t index = 0;
  for (const ColmapFrame& frame : model.frames) {
    for (const ColmapImage& image : frame.images) visit(frame, image, colmap_id(index++));
  }
}

std::vector<std::vector<TrackElement>> tracks_of(const ColmapModel& model) {
  std::vector<std::vector<TrackElement>> tracks(model.points.size());
  for_each_image(model, [&](const ColmapFrame&, const ColmapImage& image, std::uint32_t id) {
    for (std::uint32_t i = 0; i < image.observations.size(); ++i) {
      tracks[image.observations[i].point].push_back({id, i});
    }
  });
  return tracks;
}

// The binary forms.

template <typename... Numbers>
void append_all(std::string& bytes, Numbers... numbers) {
  (append_little_endian(bytes, numbers), ...);
}

void append_rigid(std::string& bytes, const SE3& pose) {
  for (const double number : colmap_pose(pose)) append_all(bytes, number);
}

std::string binary_cameras(const ColmapModel& model) {
  std::string bytes;
  append_all(bytes, std::uint64_t{model.cameras.size()});
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const Camera& camera = model.cameras[i];
    const ColmapLens lens = colmap_lens(camera);
    append_all(bytes, colmap_id(i), lens.id, static_cast<std::uint64_t>(camera.width),
               static_cast<std::uint64_t>(camera.height));
    for (const double parameter : lens.parameters) append_all(bytes, parameter);
  }
  return bytes;
}

std::string binary_images(const ColmapModel& model) {
  std::string bytes;
  append_all(bytes, counts_of(model).images);
  for_each_image(model, [&](const ColmapFrame& frame, const ColmapImage& image, std::uint32_t id) {
    append_all(bytes, id);
    append_rigid(bytes, world_T_camera(model, frame, image.camera).inverse());
    append_all(bytes, colmap_id(image.camera));
    bytes += image.name;
    append_all(bytes, '\0', std::uint64_t{image.observations.size()});
    for (const ColmapObservation& o : image.observations) {
      const Eigen::Vector2d pixel = from_corner(o.pixel);
      append_all(bytes, pixel.x(), pixel.y(), std::uint64_t{o.point + 1});
    }
  });
  return bytes;
}

std::string binary_points(const ColmapModel& model) {
  std::string bytes;
  append_all(bytes, std::uint64_t{model.points.size()});
  const auto tracks = tracks_of(model);
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& p = model.points[i];
    append_all(bytes, std::uint64_t{i + 1}, p.p_world.x(), p.p_world.y(), p.p_world.z(), p.grey,
               p.grey, p.grey, p.error, std::uint64_t{tracks[i].size()});
    for (const TrackElement& element : tracks[i])
      append_all(bytes, element.image, element.observation);
  }
  return bytes;
}

std::string binary_rigs(const ColmapModel& model) {
  std::string bytes;
  append_all(bytes, std::uint64_t{1}, kColmapRig, static_cast<std::uint32_t>(model.cameras.size()),
             kColmapCamera, colmap_id(0));
  for (std::size_t i = 1; i < model.cameras.size(); ++i) {
    append_all(bytes, kColmapCamera, colmap_id(i), std::uint8_t{1});
    append_rigid(bytes, camera_T_first(model, i));
  }
  return bytes;
}

std::string binary_frames(const ColmapModel& model) {
  std::string bytes;
  append_all(bytes, std::uint64_t{model.frames.size()});
  std::uint64_t image_id = 0;
  for (std::size_t i = 0; i < model.frames.size(); ++i) {
    const ColmapFrame& frame = model.frames[i];
    append_all(bytes, colmap_id(i), kColmapRig);
    append_rigid(bytes, world_T_camera(model, frame, 0).inverse());
    append_all(bytes, static_cast<std::uint32_t>(frame.images.size()));
    for (const ColmapImage& image : frame.images) {
      append_all(bytes, kColmapCamera, colmap_id(image.camera), ++image_id);
    }
  }
  return bytes;
}

// The text forms.

template <typename... Values>
void print_to(std::string& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
}

std::string text_images(const ColmapModel& model) {
  std::string text =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# POINTS2D[] as X Y POINT3D_ID\n";
  for_each_image(model, [&](const ColmapFrame& frame, const ColmapImage& image, std::uint32_t id) {
    if (image.name.find_first_of(" \t\n\r") != std::string::npos) {
      throw InputError(fmt::format(
          "the image '{}' has a space in its name, which COLMAP's text files cannot have, expected "
          "--as colmap, the binary files",
          image.name));
    }
    print_to(text, "{} {} {} {}\n", id,
             fmt::join(colmap_pose(world_T_camera(model, frame, image.camera).inverse()), " "),
             colmap_id(image.camera), image.name);
    for (const ColmapObservation& o : image.observations) {
      const Eigen::Vector2d pixel = from_corner(o.pixel);
      print_to(text, "{} {} {} ", pixel.x(), pixel.y(), o.point + 1);
    }
    text += '\n';
  });
  return text;
}

std::string text_points(const ColmapModel& model) {
  std::string text = "# POINT3D_ID X Y Z R G B ERROR TRACK[] as IMAGE_ID POINT2D_IDX\n";
  const auto tracks = tracks_of(model);
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& p = model.points[i];
    print_to(text, "{} {} {} {} {} {} {} {}", i + 1, p.p_world.x(), p.p_world.y(), p.p_world.z(),
             p.grey, p.grey, p.grey, p.error);
    for (const TrackElement& element : tracks[i]) {
      print_to(text, " {} {}", element.image, element.observation);
    }
    text += '\n';
  }
  return text;
}

std::string text_rigs(const ColmapModel& model) {
  std::string text =
      "# RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID SENSORS[] as SENSOR_TYPE SENSOR_ID "
      "HAS_POSE QW QX QY QZ TX TY TZ\n";
  print_to(text, "{} {} CAMERA {}", kColmapRig, model.cameras.size(), colmap_id(0));
  for (std::size_t i = 1; i < model.cameras.size(); ++i) {
    print_to(text, " CAMERA {} 1 {}", colmap_id(i),
             fmt::join(colmap_pose(camera_T_first(model, i)), " "));
  }
  return text + '\n';
}

std::string text_frames(const ColmapModel& model) {
  std::string text =
      "# FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA_IDS DATA_IDS[] as SENSOR_TYPE SENSOR_ID "
      "DATA_ID\n";
  std::uint64_t image_id = 0;
  for (std::size_t i = 0; i < model.frames.size(); ++i) {
    const ColmapFrame& frame = model.frames[i];
    print_to(text, "{} {} {} {}", colmap_id(i), kColmapRig,
             fmt::join(colmap_pose(world_T_camera(model, frame, 0).inverse()), " "),
             frame.images.size());
    for (const ColmapImage& image : frame.images) {
      print_to(text, " CAMERA {} {}", colmap_id(image.camera), ++image_id);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

ColmapFiles colmap_binary(const ColmapModel& model) {
  return {{"cameras.bin", binary_cameras(model)},
          {"images.bin", binary_images(model)},
          {"points3D.bin", binary_points(model)},
          {"rigs.bin", binary_rigs(model)},
          {"frames.bin", binary_frames(model)}};
}

ColmapFiles colmap_text(const ColmapModel& model) {
  return {{"cameras.txt", colmap_camera_lines(model.cameras)},
          {"images.txt", text_images(model)},
          {"points3D.txt", text_points(model)},
          {"rigs.txt", text_rigs(model)},
          {"frames.txt", text_frames(model)}};
}

}  // namespace chasles

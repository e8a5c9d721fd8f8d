#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/codec/image_encode.hpp>
#include <chasles/foxglove/foxglove_channels.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/image_messages.hpp>
#include <chasles/viewers/map_messages.hpp>
#include <chasles/viewers/pose_messages.hpp>
#include <chasles/viewers/recognition_messages.hpp>
#include <chasles/viewers/state_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr std::chrono::milliseconds kBetweenWays{500};
constexpr int kPictureWidth = 640;  // largest [px]

bool is_early(const RunState& state) { return state.time < Time::zero(); }

/// Whether the second list begins with the first one.
bool continues(const std::vector<RunState>& states, const std::vector<RunState>& all) {
  const auto same = [](const RunState& a, const RunState& b) {
    return a.time == b.time && a.world_T_imu.p == b.world_T_imu.p &&
           a.world_T_imu.R == b.world_T_imu.R;
  };
  return states.size() <= all.size() && std::equal(states.begin(), states.end(), all.begin(), same);
}

}  // namespace

FoxgloveChannels::FoxgloveChannels() : schemas_(foxglove_schemas()) {}
FoxgloveChannels::~FoxgloveChannels() = default;

bool FoxgloveChannels::Camera::is_shown() const {
  return annotations->subscribers > 0 || (image && image->subscribers > 0);
}

template <typename Kind, typename... Arguments>
Kind* FoxgloveChannels::declare(Arguments&&... arguments) {
  auto channel = std::make_unique<Kind>(std::forward<Arguments>(arguments)...);
  Kind* const declared = channel.get();
  channels_.push_back(std::move(channel));
  return declared;
}

LatestChannel* FoxgloveChannels::latest(const ViewerTopic& topic) {
  return declare<LatestChannel>(topic, schemas_);
}

void FoxgloveChannels::begin(FoxgloveStart start) {
  run_ = std::move(start.header);
  summary_ = std::move(start.summary);
  comparison_ = {std::move(run_.truth), run_.pairing, coordinates_of(summary_), is_level(run_)};
  declare_states();
  if (!comparison_.truth().empty()) declare_truth();
  ways_ = declare<WayChannel>(schemas_, run_, comparison_);
  map_ = latest(kMapTopic);
  ellipsoids_ = latest(kEllipsoidsTopic);
  declare_cameras(start.cameras, start.pictures);
}

void FoxgloveChannels::declare_states() {
  const auto each = [this](const ViewerTopic& topic, auto message) {
    declare<StateChannel>(
        topic, schemas_, run_.states, [this] { return run_.states.size(); },
        [this, message](std::size_t i) { return message(run_.states[i]); });
  };
  each(kTfTopic, tf_message);
  each(kPoseTopic, pose_message);
  each(kOdometryTopic, odometry_message);
  const auto states = std::make_shared<const StateMessages>(run_.extra_names);
  schemas_.emplace(kStateTopic.schema, states->schema());
  each(kStateTopic, [states](const RunState& state) { return states->message(state); });
  tf_cameras_ = latest(kTfCamerasTopic);
}

void FoxgloveChannels::declare_truth() {
  // A state is compared once the truth is placed; those before that have no truth.
  const auto each = [this](const ViewerTopic& topic, auto message) {
    declare<StateChannel>(
        topic, schemas_, run_.states, [this] { return comparison_.size(); },
        [this, message](std::size_t i) -> Json {
          const std::optional<SE3>& truth = comparison_.truth_of(i);
          return truth ? message(i, *truth) : Json(nullptr);
        });
  };
  schemas_.emplace(kErrorsTopic.schema, errors_schema());
  each(kErrorsTopic, [this](std::size_t i, const SE3&) {
    const AgainstTruth one = comparison_.of({i});
    return errors_message(run_.states[i].time, one.error[0],
                          {.position = one.nees_position[0],
                           .attitude = one.nees_attitude[0],
                           .pose = one.nees_pose[0]});
  });
  each(kTruthTopic, [this](std::size_t i, const SE3& truth) {
    return pose_in_world(run_.states[i].time, truth);
  });
  if (!run_.georeference) return;
  declare<StateChannel>(
      kLocationTopic, schemas_, run_.states,
      [this] { return comparison_.started() ? comparison_.size() : 0; },
      [this](std::size_t i) {
        return location_message(run_.states[i], comparison_.world_T_truth().inverse(),
                                *run_.georeference);
      });
}

void FoxgloveChannels::declare_cameras(int cameras, bool pictures) {
  for (int k = 0; k < cameras; ++k) {
    cameras_.push_back({.image = pictures ? latest(image_topic(k)) : nullptr,
                        .annotations = latest(annotations_topic(k))});
  }
}

std::optional<Time> FoxgloveChannels::now() const {
  return run_.states.empty() ? std::nullopt : std::optional(run_.states.back().time);
}

void FoxgloveChannels::notice(StatusLevel level, std::string text) {
  notices_.push_back({.level = level, .text = std::move(text)});
}

void FoxgloveChannels::add(const std::vector<RunState>& states) {
  if (states.empty()) return;
  const bool first = run_.states.empty();
  std::ranges::remove_copy_if(states, std::back_inserter(run_.states), is_early);
  if (std::ranges::any_of(states, is_early) && !std::exchange(reported_early_times_, true)) {
    notice(StatusLevel::kWarning,
           "states with times before 1970 are not shown: the protocol cannot express them");
  }
  comparison_.extend(run_.states);
  if (!first || run_.states.empty()) return;
  const Time time = run_.states.front().time;
  tf_cameras_->set(time, [this, time] {
    const Json summary = Json::parse(summary_, nullptr, false);
    return summary.is_object() ? cameras_message(summary, time) : Json(nullptr);
  });
}

void FoxgloveChannels::map(LiveMap map) {
  run_.landmarks = std::move(map.landmarks);
  if (map.prior_map) run_.prior_map = std::move(map.prior_map);
  show_map();
  show_closures(Json::parse(map.known, nullptr, false));
}

void FoxgloveChannels::show_map() {
  const std::optional<Time> time = now();
  if (!time) return;
  map_->set(*time, [this, time] { return map_cloud(run_.landmarks, *time); });
  ellipsoids_->set(*time, [this, time] { return map_ellipsoids(run_.landmarks, *time); });
  if (!run_.prior_map) return;
  if (!prior_map_) {
    prior_map_ = latest(kPriorMapTopic);
    tf_map_ = latest(kTfMapTopic);
  }
  prior_map_->set(*time, [this, time] { return prior_map_message(run_, *time); });
  tf_map_->set(*time, [this, time] {
    return map_frame_message(*time, run_.prior_map->world_T_map.inverse());
  });
}

void FoxgloveChannels::show_closures(const Json& known) {
  if (!known.is_object()) return;
  std::size_t count = 0;
  closure_messages(known, run_, [&](Time time, const Json& message) {
    if (!closures_) closures_ = declare<ListChannel>(kClosuresTopic, schemas_);
    if (++count > closures_->size()) closures_->append(time, message);
  });
}

bool FoxgloveChannels::shows_frames() const {
  return std::ranges::any_of(cameras_, &Camera::is_shown);
}

void FoxgloveChannels::frame(FoxgloveFrame frame) {
  const std::size_t count = std::min(cameras_.size(), frame.images.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Camera& camera = cameras_[k];
    const auto image = std::make_shared<ShownImage>(std::move(frame.images[k]));
    if (!camera.is_shown() || image->time < Time::zero()) continue;
    if (k < frame.pictures.size()) image->jpeg = jpeg_bytes(frame.pictures[k], kPictureWidth);
    if (camera.image) {
      camera.image->set(image->time, [image] { return image_message(*image); });
    }
    camera.annotations->set(image->time, [image] { return annotations_message(*image); });
  }
}

void FoxgloveChannels::show() {
  if (!ways_ || Clock::now() < next_way_) return;
  next_way_ = Clock::now() + kBetweenWays;
  ways_->show();
}

void FoxgloveChannels::finish(Run run, const std::string& summary) {
  if (!ways_) return;  // the run did not begin
  std::erase_if(run.states, is_early);
  if (!continues(run_.states, run.states)) {
    ++epoch_;
    comparison_ = {comparison_.truth(), run_.pairing, coordinates_of(summary_), is_level(run_)};
    run_.states.clear();
  }
  const auto shown = static_cast<std::ptrdiff_t>(run_.states.size());
  add({run.states.begin() + shown, run.states.end()});
  ways_->show();
  run_.landmarks = std::move(run.landmarks);
  if (run.prior_map) run_.prior_map = std::move(run.prior_map);
  show_map();
  show_closures(Json::parse(summary, nullptr, false));
}

}  // namespace chasles

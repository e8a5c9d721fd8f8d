#include <cmath>
#include <set>
#include <string_view>

#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/state_messages.hpp>
#include <chasles/viewers/topics.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kTimestamp = "google.protobuf.Timestamp timestamp = 1";
constexpr int kExtraFields = 40;  // numbers of fields from here on

ProtoMessage state_schema() {
  return proto_message(
      kStateTopic.schema,
      {kTimestamp, "string health = 2", "double nis = 3", "int32 nis_dof = 4",
       "double nis_per_dof = 5", "double nis_per_dof_low = 6", "double nis_per_dof_high = 7",
       "int32 observations = 8", "int32 used = 9", "int32 rejected = 10", "int32 added = 11",
       "int32 in_state = 12", "int32 landmarks = 13", "double sigma_rx_deg = 14",
       "double sigma_ry_deg = 15", "double sigma_rz_deg = 16", "double sigma_x_m = 17",
       "double sigma_y_m = 18", "double sigma_z_m = 19"});
}

// A valid Protocol Buffers name that no other field has.
std::string field_name(std::string name, std::set<std::string>& taken) {
  for (char& c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (!letter && !(c >= '0' && c <= '9')) c = '_';
  }
  if (name.empty() || !((name[0] | 0x20) >= 'a' && (name[0] | 0x20) <= 'z')) name = "value_" + name;
  while (!taken.insert(name).second) name += "_";
  return name;
}

Json figures(const RunState& s) {
  Json value = {{"timestamp", proto_time(s.time)},
                {"health", s.health},
                {"nis", s.nis},
                {"nis_dof", s.nis_dof},
                {"observations", s.observations},
                {"used", s.used},
                {"rejected", s.rejected},
                {"added", s.added},
                {"in_state", s.in_state},
                {"landmarks", s.landmarks}};
  if (s.nis_dof > 0) {
    const Band band = chi2_band(s.nis_dof, 1);
    value["nis_per_dof"] = s.nis / s.nis_dof;
    value["nis_per_dof_low"] = band.low / s.nis_dof;
    value["nis_per_dof_high"] = band.high / s.nis_dof;
  }
  const Vector6d sigma = s.pose_covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const char* const names[] = {"sigma_rx_deg", "sigma_ry_deg", "sigma_rz_deg",
                               "sigma_x_m",    "sigma_y_m",    "sigma_z_m"};
  for (int k = 0; k < 6; ++k) value[names[k]] = (k < 3 ? kDegrees : 1) * sigma(k);
  return value;
}

}  // namespace

StateMessages::StateMessages(const std::vector<std::string>& extra_names)
    : schema_(state_schema()) {
  std::set<std::string> taken;
  for (const ProtoField& field : schema_.fields) taken.insert(field.name);
  int number = kExtraFields;
  const auto add = [&](const std::string& name, std::vector<std::string>& list) {
    list.push_back(field_name(name, taken));
    ProtoField& field = schema_.fields.emplace_back();
    field.name = list.back();
    field.number = number++;
  };
  for (const std::string& name : extra_names) add(name, values_);
  for (const std::string& name : extra_names) add("sigma_" + name, sigmas_);
}

Json StateMessages::message(const RunState& s) const {
  Json value = figures(s);
  for (std::size_t k = 0; k < values_.size(); ++k) {
    if (k < s.extra.size()) value[values_[k]] = s.extra[k];
    if (k < s.extra_sigma.size()) value[sigmas_[k]] = s.extra_sigma[k];
  }
  return value;
}

ProtoMessage errors_schema() {
  return proto_message(
      kErrorsTopic.schema,
      {kTimestamp, "double attitude_x_deg = 2", "double attitude_y_deg = 3",
       "double attitude_z_deg = 4", "double x_m = 5", "double y_m = 6", "double z_m = 7",
       "double nees_pose = 8", "double nees_attitude = 9", "double nees_position = 10"});
}

Json errors_message(Time time, const Vector6d& error, const PoseNees& nees) {
  const char* const names[] = {
      "attitude_x_deg", "attitude_y_deg", "attitude_z_deg", "x_m", "y_m", "z_m"};
  Json value = {{"timestamp", proto_time(time)},
                {"nees_pose", nees.pose},
                {"nees_attitude", nees.attitude},
                {"nees_position", nees.position}};
  for (int k = 0; k < 6; ++k) value[names[k]] = (k < 3 ? kDegrees : 1) * error(k);
  return value;
}

void add_states(const Run& run, Channels& out) {
  const StateMessages messages(run.extra_names);
  out.declare(messages.schema());
  for (const RunState& s : run.states) out.add(kStateTopic, s.time, messages.message(s));
}

void add_errors(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!errors.problem.empty()) return;
  out.declare(errors_schema());
  for (const std::size_t i : errors.matched.estimate_index) {
    const PoseNees nees{.position = errors.nees_position[i],
                        .attitude = errors.nees_attitude[i],
                        .pose = errors.nees_pose[i]};
    const Time time = run.states[i].time;
    out.add(kErrorsTopic, time, errors_message(time, errors.error[i], nees));
  }
}

}  // namespace chasles

#include <cmath>
#include <set>
#include <string_view>

#include <nlohmann/json.hpp>

#include <chasles/constants.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/state_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kTimestamp = "google.protobuf.Timestamp timestamp = 1";
constexpr int kExtraFields = 40;  // numbers of fields from here on

ProtoMessage state_schema() {
  return proto_message(
      "chasles.State",
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

// The names of the extra numbers, and of their standard deviations.
struct ExtraFields {
  std::vector<std::string> value, sigma;
};

ExtraFields add_extra_fields(const std::vector<std::string>& names, ProtoMessage& schema) {
  std::set<std::string> taken;
  for (const ProtoField& field : schema.fields) taken.insert(field.name);
  ExtraFields fields;
  int number = kExtraFields;
  const auto add = [&](const std::string& name, std::vector<std::string>& list) {
    list.push_back(field_name(name, taken));
    ProtoField& field = schema.fields.emplace_back();
    field.name = list.back();
    field.number = number++;
  };
  for (const std::string& name : names) add(name, fields.value);
  for (const std::string& name : names) add("sigma_" + name, fields.sigma);
  return fields;
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

void add_states(const Run& run, Channels& out) {
  ProtoMessage schema = state_schema();
  const ExtraFields extra = add_extra_fields(run.extra_names, schema);
  out.declare(schema);
  for (const RunState& s : run.states) {
    Json value = figures(s);
    for (std::size_t k = 0; k < extra.value.size(); ++k) {
      if (k < s.extra.size()) value[extra.value[k]] = s.extra[k];
      if (k < s.extra_sigma.size()) value[extra.sigma[k]] = s.extra_sigma[k];
    }
    out.add("/state", "chasles.State", s.time, value);
  }
}

void add_errors(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!errors.problem.empty()) return;
  out.declare(proto_message(
      "chasles.Errors",
      {kTimestamp, "double attitude_x_deg = 2", "double attitude_y_deg = 3",
       "double attitude_z_deg = 4", "double x_m = 5", "double y_m = 6", "double z_m = 7",
       "double nees_pose = 8", "double nees_attitude = 9", "double nees_position = 10"}));
  const char* const names[] = {
      "attitude_x_deg", "attitude_y_deg", "attitude_z_deg", "x_m", "y_m", "z_m"};
  for (const std::size_t i : errors.matched.estimate_index) {
    Json value = {{"timestamp", proto_time(run.states[i].time)},
                  {"nees_pose", errors.nees_pose[i]},
                  {"nees_attitude", errors.nees_attitude[i]},
                  {"nees_position", errors.nees_position[i]}};
    for (int k = 0; k < 6; ++k) value[names[k]] = (k < 3 ? kDegrees : 1) * errors.error[i](k);
    out.add("/errors", "chasles.Errors", run.states[i].time, value);
  }
}

}  // namespace chasles

#include "node.hpp"

#include <fmt/format.h>

#include <chasles/base/error.hpp>

namespace chasles::ros1 {
namespace {

constexpr double kDiagnosisPeriod = 1;  // [s]
const char* const kNotCalibrated = "the cameras are not calibrated yet";

}  // namespace

Node::Node(Transport& transport)
    : transport_(transport),
      parameters_(parameters_from(transport.parameters())),
      publisher_(transport, parameters_),
      intake_(transport, parameters_, publisher_) {
  transport.serve("reset", [this] { return reset(); });
  transport.serve("save_map", [this] { return save_map(); });
  transport.every(kDiagnosisPeriod, [this] { diagnose(); });
}

void Node::run() {
  transport_.wait(parameters_.lossless);
  intake_.finish();
  app::RobotSlam* slam = intake_.slam();
  if (slam == nullptr) {
    throw UsageError(fmt::format("{}: {}", kNotCalibrated, intake_.waiting_for()));
  }
  diagnose();
  slam->write_outputs();
}

std::pair<bool, std::string> Node::reset() {
  if (intake_.slam() == nullptr) return {false, kNotCalibrated};
  intake_.slam()->reset("reset was called");
  return {true, "the run begins anew"};
}

std::pair<bool, std::string> Node::save_map() {
  if (intake_.slam() == nullptr) return {false, kNotCalibrated};
  if (parameters_.save_map.empty()) {
    return {false, "~save_map is not set, expected the file of the map"};
  }
  try {
    return {true, intake_.slam()->save_map()};
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
}

void Node::diagnose() { transport_.publish_diagnosis(diagnosis()); }

OutDiagnosis Node::diagnosis() {
  if (intake_.slam() == nullptr) {
    return {.level = DiagnosisLevel::kWarning,
            .message = fmt::format("{}: {}", kNotCalibrated, intake_.waiting_for()),
            .values = {}};
  }
  const app::RobotReport now = intake_.slam()->report();
  const NodeCounts counts = intake_.counts();
  const OutDiagnosis result = diagnosis_of(now, before_, counts, counts_before_);
  before_ = now;
  counts_before_ = counts;
  return result;
}

}  // namespace chasles::ros1

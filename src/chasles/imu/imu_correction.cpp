#include <array>

#include <chasles/imu/imu_correction.hpp>

namespace chasles {
namespace {

enum class Of { kForce, kRate, kRateOfForce };

// A parameter: an entry of one of the matrices.
struct Entry {
  Of of;
  int row, column;
};

constexpr std::array<Entry, ImuCorrection::kScales> kScaleEntries{{{Of::kForce, 0, 0},
                                                                   {Of::kForce, 1, 1},
                                                                   {Of::kForce, 2, 2},
                                                                   {Of::kRate, 0, 0},
                                                                   {Of::kRate, 1, 1},
                                                                   {Of::kRate, 2, 2}}};
constexpr std::array<Entry, ImuCorrection::kMisalignments> kMisalignmentEntries{
    {{Of::kForce, 1, 0},
     {Of::kForce, 2, 0},
     {Of::kForce, 2, 1},
     {Of::kRate, 0, 1},
     {Of::kRate, 0, 2},
     {Of::kRate, 1, 0},
     {Of::kRate, 1, 2},
     {Of::kRate, 2, 0},
     {Of::kRate, 2, 1}}};
constexpr std::array<Entry, ImuCorrection::kGSensitivities> kGSensitivityEntries{
    {{Of::kRateOfForce, 0, 0},
     {Of::kRateOfForce, 0, 1},
     {Of::kRateOfForce, 0, 2},
     {Of::kRateOfForce, 1, 0},
     {Of::kRateOfForce, 1, 1},
     {Of::kRateOfForce, 1, 2},
     {Of::kRateOfForce, 2, 0},
     {Of::kRateOfForce, 2, 1},
     {Of::kRateOfForce, 2, 2}}};

// Calls visit(row of the parameters, entry) for those that the correction has.
template <typename Visitor>
void for_each_entry(const ImuCorrection& correction, Visitor&& visit) {
  int row = 0;
  const auto visit_all = [&](bool has, const auto& entries) {
    if (!has) return;
    for (const Entry& entry : entries) visit(row++, entry);
  };
  visit_all(correction.has_scale, kScaleEntries);
  visit_all(correction.has_misalignment, kMisalignmentEntries);
  visit_all(correction.has_g_sensitivity, kGSensitivityEntries);
}

template <typename Correction>
auto& value(Correction& correction, const Entry& entry) {
  auto& matrix = entry.of == Of::kForce  ? correction.force
                 : entry.of == Of::kRate ? correction.rate
                                         : correction.rate_of_force;
  return matrix(entry.row, entry.column);
}

std::string name(const Entry& entry) {
  const char row = "xyz"[entry.row], column = "xyz"[entry.column];
  if (entry.of == Of::kRateOfForce) return std::string("g_sensitivity_") + row + '_' + column;
  const std::string sensor = entry.of == Of::kForce ? "accelerometer" : "gyroscope";
  return entry.row == entry.column ? sensor + "_scale_" + row
                                   : sensor + "_misalignment_" + row + '_' + column;
}

void correct(const ImuCorrection& correction, Eigen::Vector3d& force, Eigen::Vector3d& rate) {
  force += (correction.force * force).eval();
  rate += (correction.rate * rate - correction.rate_of_force * force).eval();
}

}  // namespace

ImuCorrection::Parameters ImuCorrection::parameters() const {
  Parameters result(size());
  for_each_entry(*this, [&](int row, const Entry& entry) { result[row] = value(*this, entry); });
  return result;
}

void ImuCorrection::set(const Eigen::Ref<const Eigen::VectorXd>& parameters) {
  for_each_entry(*this,
                 [&](int row, const Entry& entry) { value(*this, entry) = parameters[row]; });
}

void ImuCorrection::add(const Eigen::Ref<const Eigen::VectorXd>& errors) {
  for_each_entry(*this, [&](int row, const Entry& entry) { value(*this, entry) += errors[row]; });
}

std::vector<std::string> ImuCorrection::names() const {
  std::vector<std::string> result;
  for_each_entry(*this, [&](int, const Entry& entry) { result.push_back(name(entry)); });
  return result;
}

ImuCorrection::Derivative ImuCorrection::derivative(const Eigen::Vector3d& force_measured,
                                                    const Eigen::Vector3d& rate_measured) const {
  Derivative result = Derivative::Zero(6, size());
  const Eigen::Vector3d corrected_force = force_measured + force * force_measured;
  for_each_entry(*this, [&](int row, const Entry& entry) {
    auto column = result.col(row);
    switch (entry.of) {
      case Of::kForce:
        column[entry.row] = force_measured[entry.column];
        column.tail<3>() = -rate_of_force.col(entry.row) * force_measured[entry.column];
        break;
      case Of::kRate:
        column[3 + entry.row] = rate_measured[entry.column];
        break;
      case Of::kRateOfForce:
        column[3 + entry.row] = -corrected_force[entry.column];
        break;
    }
  });
  return result;
}

ImuInterval corrected(const ImuCorrection& correction, ImuInterval interval) {
  correct(correction, interval.specific_force_imu, interval.angular_rate_imu);
  return interval;
}

ImuSample corrected(const ImuCorrection& correction, ImuSample sample) {
  correct(correction, sample.specific_force_imu, sample.angular_rate_imu);
  return sample;
}

ImuSample corrected(const ImuCorrection& correction, const ImuRange& measured, ImuSample sample) {
  const auto saturated = [](const Eigen::Vector3d& value, double range) {
    return value.cwiseAbs().maxCoeff() >= range;
  };
  sample.force_clipped |= saturated(sample.specific_force_imu, measured.accelerometer);
  sample.rate_clipped |= saturated(sample.angular_rate_imu, measured.gyroscope);
  return corrected(correction, sample);
}

}  // namespace chasles

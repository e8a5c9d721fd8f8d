#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/video/gpmf.hpp>
#include <chasles/video/sample_times.hpp>
#include <chasles/video/telemetry.hpp>

namespace chasles {
namespace {

constexpr const char* kForces = "ACCL";
constexpr const char* kRates = "GYRO";
constexpr std::string_view kAxes = "XYZ";

/// The streams of one payload, and its number.
struct ReadPayload {
  std::size_t number = 0;
  std::vector<GpmfSamples> streams;
};

std::vector<ReadPayload> read_payloads(const VideoIndex& index, std::vector<std::string>& remarks) {
  std::vector<ReadPayload> payloads;
  std::string first_error;
  for (std::size_t i = 0; i < index.telemetry.size(); ++i) {
    const std::string where =
        fmt::format("{}: telemetry at {:.3f} s", index.file, to_seconds(index.telemetry[i].time));
    try {
      payloads.push_back(
          {.number = i,
           .streams = gpmf_streams(index.telemetry[i].bytes, {kForces, kRates}, where)});
    } catch (const InputError& error) {
      if (first_error.empty()) first_error = error.what();
    }
  }
  if (payloads.empty()) {
    throw InputError(first_error.empty()
                         ? fmt::format("{}: its telemetry (gpmd) is empty", index.file)
                         : first_error);
  }
  const std::size_t damaged = index.telemetry.size() - payloads.size();
  if (damaged > 0) {
    remarks.push_back(
        fmt::format("{} of {} payloads of telemetry are damaged: left out; the first: "
                    "{}",
                    damaged, index.telemetry.size(), first_error));
  }
  return payloads;
}

// The device of a payload's stream, for a stream of this key.
std::vector<std::string> devices_with(const std::vector<ReadPayload>& payloads,
                                      std::string_view key) {
  std::vector<std::string> devices;
  for (const ReadPayload& payload : payloads) {
    for (const GpmfSamples& stream : payload.streams) {
      const bool known = std::ranges::find(devices, stream.device) != devices.end();
      if (stream.key == key && stream.count > 0 && !known) devices.push_back(stream.device);
    }
  }
  return devices;
}

std::string choose_device(const VideoIndex& index, const std::vector<ReadPayload>& payloads) {
  const auto forces = devices_with(payloads, kForces), rates = devices_with(payloads, kRates);
  for (const std::string& device : forces) {
    if (std::ranges::find(rates, device) != rates.end()) return device;
  }
  throw InputError(fmt::format(
      "{}: its telemetry has {}, expected both an accelerometer (ACCL) and a gyroscope (GYRO): "
      "cameras without them need a table of an IMU beside the video",
      index.file,
      forces.empty() && rates.empty()
          ? "samples of neither sensor"
          : fmt::format("no samples of {} for those of {}", rates.empty() ? kRates : kForces,
                        rates.empty() ? kForces : kRates)));
}

/// A stream over all payloads.
struct WholeStream {
  std::vector<SampleBlock> blocks;
  std::vector<const GpmfSamples*> parts;  // one for each block
};

// Numbers of samples by their totals, if these fit one another; else by counting.
void number_samples(WholeStream& stream) {
  std::uint64_t next = 0;
  bool totals = true;
  for (std::size_t k = 0; k < stream.blocks.size() && totals; ++k) {
    const auto& total = stream.parts[k]->total;
    const std::uint64_t count = stream.blocks[k].count;
    totals = total && *total >= count && *total - count >= next;
    next = totals ? *total : 0;
  }
  next = 0;
  for (std::size_t k = 0; k < stream.blocks.size(); ++k) {
    SampleBlock& block = stream.blocks[k];
    block.first = totals ? *stream.parts[k]->total - block.count : next;
    next = block.first + block.count;
  }
}

WholeStream whole_stream(const VideoIndex& index, const std::vector<ReadPayload>& payloads,
                         const std::string& device, std::string_view key) {
  WholeStream whole;
  for (const ReadPayload& payload : payloads) {
    const TelemetryPayload& stated = index.telemetry[payload.number];
    for (const GpmfSamples& stream : payload.streams) {
      if (stream.key != key || stream.device != device || stream.count == 0) continue;
      whole.blocks.push_back({.payload = payload.number,
                              .begin = stated.time,
                              .duration = stated.duration,
                              .first = 0,
                              .count = stream.count,
                              .stamp = stream.stamp,
                              .delay = stream.delay});
      whole.parts.push_back(&stream);
    }
  }
  number_samples(whole);
  return whole;
}

// The signed axes that letters state, one row for each.
Eigen::Matrix3d rows_of_axes(const std::string& letters, const std::string& where) {
  Eigen::Matrix3d rows = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < std::min<std::size_t>(3, letters.size()); ++i) {
    const auto letter = static_cast<unsigned char>(letters[i]);
    const std::size_t axis = kAxes.find(static_cast<char>(std::toupper(letter)));
    if (axis == std::string_view::npos) continue;
    rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) =
        std::isupper(letter) != 0 ? 1 : -1;
  }
  if (letters.size() == 3 && std::abs(rows.determinant()) == 1) return rows;
  throw InputError(
      fmt::format("{}: states the axes '{:.20}', expected X, Y and Z, each once, "
                  "small ones for the negative axes",
                  where, letters));
}

// From the channels to GoPro's X, Y, Z.
Eigen::Matrix3d axes_of_channels(const GpmfSamples& stream, const std::string& where) {
  if (stream.matrix.size() == 9 && !stream.axes_out.empty()) {
    Eigen::Matrix3d matrix;
    for (Eigen::Index i = 0; i < 9; ++i) {
      matrix(i / 3, i % 3) = stream.matrix[static_cast<std::size_t>(i)];
    }
    if (matrix.allFinite() && matrix.determinant() != 0) {
      return rows_of_axes(stream.axes_out, where).transpose() * matrix;
    }
    throw InputError(fmt::format("{}: its MTRX is no matrix of axes", where));
  }
  return rows_of_axes(stream.axes_in.empty() ? "ZXY" : stream.axes_in, where).transpose();
}

double unit_of(const GpmfSamples& stream, const std::string& where) {
  const bool forces = stream.key == kForces;
  const auto factor =
      factor_of_unit(stream.unit, forces ? ImuQuantity::kForce : ImuQuantity::kRate);
  if (factor) return *factor;
  throw InputError(fmt::format("{}: has the unit '{:.20}', expected {}", where, stream.unit,
                               forces ? "m/s^2 or g" : "rad/s or deg/s"));
}

std::vector<AxesSample> samples_at(const VideoIndex& index, const WholeStream& stream,
                                   const std::vector<double>& times) {
  std::vector<AxesSample> samples;
  for (const GpmfSamples* part : stream.parts) {
    const std::string where = fmt::format("{}: telemetry {}", index.file, part->key);
    const Eigen::Matrix3d to_axes = unit_of(*part, where) * axes_of_channels(*part, where);
    for (const std::vector<double>& channels : part->samples) {
      if (channels.size() != 3) {
        throw InputError(
            fmt::format("{}: has {} channels, expected three", where, channels.size()));
      }
      const double seconds = times[samples.size()];
      if (!(std::abs(seconds) < static_cast<double>(kLastSecond))) {
        throw InputError(
            fmt::format("{}: a sample has the time {:.6g} s, which is no time", where, seconds));
      }
      samples.push_back({.time = from_seconds(seconds),
                         .value = to_axes * Eigen::Map<const Eigen::Vector3d>(channels.data())});
    }
  }
  return samples;
}

/// The clock of the stamps, and where it is from.
struct StampClock {
  Line line;
  std::string by;
};

StampClock clock_of_stamps(const VideoIndex& index, const std::vector<ReadPayload>& payloads,
                           const std::string& device, const WholeStream& forces,
                           const WholeStream& rates) {
  for (const char* key : kStreamsOfPictures) {
    const WholeStream of_pictures = whole_stream(index, payloads, device, key);
    if (const auto line = clock_by_pictures(of_pictures.blocks, index.pictures)) {
      return {.line = *line, .by = fmt::format("those of the pictures' {}", key)};
    }
  }
  const SampleBlock &a = forces.blocks.front(), &b = rates.blocks.front();
  const SampleBlock& first = *a.stamp <= *b.stamp ? a : b;
  return {.line = {.x0 = static_cast<double>(*first.stamp),
                   .y0 = to_seconds(first.begin),
                   .slope = 1e-6},
          .by = "the start of the first payload, for no stream has a sample for each picture"};
}

double rate_of(const std::vector<AxesSample>& samples) {
  const double span = to_seconds(samples.back().time - samples.front().time);
  return span > 0 ? static_cast<double>(samples.size() - 1) / span : 0;
}

}  // namespace

Telemetry read_telemetry(const VideoIndex& index, std::vector<std::string>& remarks) {
  const std::vector<ReadPayload> payloads = read_payloads(index, remarks);
  const std::string device = choose_device(index, payloads);
  const WholeStream forces = whole_stream(index, payloads, device, kForces),
                    rates = whole_stream(index, payloads, device, kRates);
  Telemetry telemetry;
  std::string times;
  if (are_stamped(forces.blocks) && are_stamped(rates.blocks)) {
    const StampClock clock = clock_of_stamps(index, payloads, device, forces, rates);
    telemetry.forces = samples_at(index, forces, stamped_times(forces.blocks, clock.line));
    telemetry.rates = samples_at(index, rates, stamped_times(rates.blocks, clock.line));
    times = fmt::format("their stamps and {}", clock.by);
  } else {
    telemetry.forces = samples_at(index, forces, times_by_payloads(forces.blocks));
    telemetry.rates = samples_at(index, rates, times_by_payloads(rates.blocks));
    times = "the starts of the payloads, for they have no stamps";
  }
  const bool stated = !rates.parts.front()->axes_in.empty();
  remarks.push_back(fmt::format(
      "the IMU is that of the video's telemetry ({}): accelerometer at {:.4g} Hz, gyroscope at "
      "{:.4g} Hz, times by {}; axes {}",
      device, rate_of(telemetry.forces), rate_of(telemetry.rates), times,
      stated ? "as it states them" : "in the order Z, X, Y, for it states none"));
  return telemetry;
}

}  // namespace chasles

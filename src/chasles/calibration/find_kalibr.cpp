#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/kalibr.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kChain = "camchain-imucam";
constexpr std::string_view kOpenVinsCameras = "kalibr_imucam_chain",
                           kOpenVinsImu = "kalibr_imu_chain";

bool holds(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

// A file that may be meant; a lower rank is better.
struct Candidate {
  fs::path file;
  int rank;
};

// The rank of a camera file by its name without ending; none if it is no such file.
std::optional<int> camera_rank(const std::string& stem) {
  if (holds(stem, kChain) || stem == "kalibr_imucam_chain") return 0;
  if (holds(stem, "camchain")) return 1;
  return std::nullopt;
}

// The rank of OpenVINS's camera file with a suffix, as kalibr_imucam_chain_X3_FINAL.
std::optional<int> suffix_rank(const std::string& stem) {
  return stem.starts_with(kOpenVinsCameras) ? std::optional(0) : std::nullopt;
}

// The name of Kalibr's IMU result beside X-camchain-imucam or camchain-imucam-X; empty without X.
std::string partner_of(const std::string& camera_stem) {
  if (camera_stem.starts_with(kOpenVinsCameras) && camera_stem != kOpenVinsCameras) {
    return std::string(kOpenVinsImu) + camera_stem.substr(kOpenVinsCameras.size());
  }
  const std::size_t at = camera_stem.find(kChain);
  if (at == std::string::npos || camera_stem == kChain) return {};
  std::string partner = camera_stem;
  return partner.replace(at, kChain.size(), "imu");
}

std::optional<int> imu_rank(const std::string& stem, const std::string& partner) {
  if (!partner.empty() && stem == partner) return 0;
  if (stem.ends_with("-imu") || stem.starts_with("imu-") || stem == "kalibr_imu_chain") return 1;
  if (stem.starts_with("imu")) return 2;
  return std::nullopt;
}

template <typename Rank>
std::vector<Candidate> candidates(const fs::path& folder, const Rank& rank_of) {
  std::vector<Candidate> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& file = entry.path();
    if (file.filename().string().starts_with(".")) continue;  // ._imu.yaml of macOS
    if (file.extension() != ".yaml" && file.extension() != ".yml") continue;
    if (const auto rank = rank_of(file.stem().string())) found.push_back({file, *rank});
  }
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.rank, a.file) < std::pair(b.rank, b.file);
  });
  return found;
}

// The best file. The others are named in a remark.
std::optional<fs::path> best(const fs::path& folder, const std::vector<Candidate>& found,
                             const std::string& why, std::vector<std::string>& remarks) {
  if (found.empty()) return std::nullopt;
  const std::string first = found[0].file.filename().string();
  for (std::size_t i = 1; i < found.size(); ++i) {
    const std::string other = found[i].file.filename().string();
    if (found[i].rank == found[0].rank) {
      throw InputError(
          fmt::format("{}: there are {} and {}, expected one of them: take the other "
                      "away",
                      folder.string(), first, other));
    }
    remarks.push_back(fmt::format("{} is read, and {} is not: {}", first, other, why));
  }
  return found[0].file;
}

std::optional<fs::path> best_imu(const fs::path& folder, const std::string& partner,
                                 std::vector<std::string>& remarks) {
  const auto rank = [&](const std::string& stem) { return imu_rank(stem, partner); };
  return best(folder, candidates(folder, rank), "the former is Kalibr's result", remarks);
}

}  // namespace

std::optional<fs::path> find_kalibr_imu(const fs::path& folder) {
  std::vector<std::string> ignored;
  return best_imu(folder, "", ignored);
}

std::optional<KalibrFiles> find_kalibr(const fs::path& folder) {
  KalibrFiles files;
  std::vector<Candidate> found = candidates(folder, camera_rank);
  if (found.empty()) found = candidates(folder, suffix_rank);
  const auto cameras =
      best(folder, found, "the former is the calibration with the IMU", files.remarks);
  if (!cameras) return std::nullopt;
  files.cameras = *cameras;
  const auto imu = best_imu(folder, partner_of(cameras->stem().string()), files.remarks);
  if (!imu) {
    throw InputError(
        fmt::format("{}: there is no imu.yaml beside {}, expected the noise of the IMU as Kalibr "
                    "takes it",
                    folder.string(), cameras->filename().string()));
  }
  files.imu = *imu;
  return files;
}

}  // namespace chasles

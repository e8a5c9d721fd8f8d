#include <algorithm>
#include <cmath>

#include <chasles/loop/spatial_choice.hpp>

namespace chasles {
namespace {

int side_of(const Eigen::Vector3f& direction) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return direction(axis) < 0 ? axis + 3 : axis;
}

}  // namespace

SpatialChoice::Cell SpatialChoice::cell(const Chosen& chosen) const {
  const auto level = static_cast<int>(std::lround(std::log2(edge_ * chosen.distance)));
  const Eigen::Vector3d scaled = chosen.p_map * std::exp2(-level);
  return {level, chosen.side, static_cast<int>(std::floor(scaled.x())),
          static_cast<int>(std::floor(scaled.y())), static_cast<int>(std::floor(scaled.z()))};
}

bool SpatialChoice::choose(LandmarkId id, const Eigen::Vector3d& p_map, double distance,
                           const Eigen::Vector3f& from) {
  if (chosen_.contains(id)) return true;
  if (!p_map.allFinite() || !(distance > 0)) return false;
  const Chosen chosen{
      .p_map = p_map, .distance = distance, .side = side_of(from), .order = order_++};
  if (!cells_.insert(cell(chosen)).second) return false;
  chosen_.emplace(id, chosen);
  return true;
}

void SpatialChoice::give_up(LandmarkId id) {
  const auto chosen = chosen_.extract(id);
  if (!chosen.empty()) cells_.erase(cell(chosen.mapped()));
}

std::vector<LandmarkId> SpatialChoice::thin() {
  constexpr double kWider = 1.15;
  std::vector<LandmarkId> dropped;
  while (size() > most_) {
    edge_ *= kWider;
    std::vector<LandmarkId> ids;
    for (const auto& [id, chosen] : chosen_) ids.push_back(id);
    std::ranges::sort(ids, {}, [&](LandmarkId id) { return chosen_.at(id).order; });
    cells_.clear();
    for (const LandmarkId id : ids) {
      if (cells_.insert(cell(chosen_.at(id))).second) continue;
      chosen_.erase(id);
      dropped.push_back(id);
    }
  }
  return dropped;
}

}  // namespace chasles

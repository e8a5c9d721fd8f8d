#include <algorithm>
#include <cstring>

#include <opencv2/features2d.hpp>

#include <chasles/loop/descriptor.hpp>

namespace chasles {
namespace {

// The comparisons reach 15 px from the centre, after a blur that reaches 3 px further.
constexpr int kReach = 18;
// ORB wants this much space around a keypoint.
constexpr int kBorder = 22;
constexpr int kSide = 2 * kBorder + 1;

bool contains(const GrayImage& image, const Eigen::Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= image.width - 1 && p.y() <= image.height - 1;
}

bool is_inside(const GrayImage& image, const ImagePatch& patch) {
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      if (!contains(image, patch.centre + patch.step * (kReach * Eigen::Vector2d(x, y)))) {
        return false;
      }
    }
  }
  return true;
}

// The part of the patch that matters, bilinear. In steps of up to 2.4 px, ORB's blur of the patch
// takes care of what lies between the samples.
void sample(const GrayImage& image, const ImagePatch& patch, cv::Mat& to, int column) {
  const Eigen::Vector2f centre = patch.centre.cast<float>();
  const Eigen::Matrix2f A = patch.step.cast<float>();
  const auto x_end = static_cast<float>(image.width) - 1.001F;
  const auto y_end = static_cast<float>(image.height) - 1.001F;
  const auto stride = static_cast<std::ptrdiff_t>(image.width);
  const std::uint8_t* pixels = image.pixels.data();
  for (int r = kBorder - kReach; r <= kBorder + kReach; ++r) {
    std::uint8_t* row = to.ptr<std::uint8_t>(r) + column;
    const auto down = static_cast<float>(r - kBorder);
    const float row_x = centre.x() + A(0, 1) * down, row_y = centre.y() + A(1, 1) * down;
    for (int c = kBorder - kReach; c <= kBorder + kReach; ++c) {
      const auto right = static_cast<float>(c - kBorder);
      const float x = std::min(std::max(row_x + A(0, 0) * right, 0.0F), x_end);
      const float y = std::min(std::max(row_y + A(1, 0) * right, 0.0F), y_end);
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
      const std::uint8_t* at = pixels + j * stride + i;
      const auto value = [&](std::ptrdiff_t k) { return static_cast<float>(at[k]); };
      const float above = value(0) + u * (value(1) - value(0));
      const float below = value(stride) + u * (value(stride + 1) - value(stride));
      row[c] = static_cast<std::uint8_t>(above + v * (below - above) + 0.5F);
    }
  }
}

}  // namespace

struct Describer::Orb {
  cv::Ptr<cv::ORB> orb = cv::ORB::create(500, 1.2F, 1, kBorder - 1);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat patches, descriptors;
};

Describer::Describer() : orb_(std::make_unique<Orb>()) {}
Describer::~Describer() = default;

std::vector<std::optional<Descriptor>> Describer::describe(const GrayImage& image,
                                                           std::span<const ImagePatch> patches) {
  std::vector<std::optional<Descriptor>> result(patches.size());
  std::vector<std::size_t> inside;
  if (image.width < 2 || image.height < 2) return result;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i].step.allFinite() && is_inside(image, patches[i])) inside.push_back(i);
  }
  if (inside.empty()) return result;
  orb_->patches = cv::Mat::zeros(kSide, kSide * static_cast<int>(inside.size()), CV_8UC1);
  orb_->keypoints.clear();
  for (std::size_t k = 0; k < inside.size(); ++k) {
    const int column = kSide * static_cast<int>(k);
    sample(image, patches[inside[k]], orb_->patches, column);
    const auto x = static_cast<float>(column + kBorder), y = static_cast<float>(kBorder);
    orb_->keypoints.emplace_back(x, y, 31.F, 0.F);
  }
  orb_->orb->compute(orb_->patches, orb_->keypoints, orb_->descriptors);
  CV_Assert(orb_->keypoints.size() == inside.size());
  for (std::size_t k = 0; k < inside.size(); ++k) {
    std::memcpy(result[inside[k]].emplace().data(), orb_->descriptors.ptr(static_cast<int>(k)),
                sizeof(Descriptor));
  }
  return result;
}

}  // namespace chasles

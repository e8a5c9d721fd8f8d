#include <algorithm>
#include <cmath>
#include <cstring>

#include <opencv2/features2d.hpp>

#include <chasles/recognise/descriptor.hpp>

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

// Bilinear; beyond the border the nearest pixel.
double value_at(const GrayImage& image, double x, double y) {
  x = std::clamp(x, 0.0, image.width - 1.0);
  y = std::clamp(y, 0.0, image.height - 1.0);
  const int i = std::min(static_cast<int>(x), image.width - 2);
  const int j = std::min(static_cast<int>(y), image.height - 2);
  const double u = x - i, v = y - j;
  const std::uint8_t* at = image.pixels.data() + static_cast<std::ptrdiff_t>(j) * image.width + i;
  const double above = at[0] + u * (at[1] - at[0]);
  const double below = at[image.width] + u * (at[image.width + 1] - at[image.width]);
  return above + v * (below - above);
}

// A pixel of a patch coarser than the image is the mean of four values.
void sample(const GrayImage& image, const ImagePatch& patch, cv::Mat& to, int column) {
  constexpr double kFine = 1.2;
  const Eigen::Matrix2d& A = patch.step;
  const bool fine = A.colwise().norm().maxCoeff() <= kFine;
  const Eigen::Vector2d right = A.col(0) / 4, down = A.col(1) / 4;
  for (int r = 0; r < kSide; ++r) {
    std::uint8_t* row = to.ptr<std::uint8_t>(r) + column;
    for (int c = 0; c < kSide; ++c) {
      const Eigen::Vector2d p = patch.centre + A * Eigen::Vector2d(c - kBorder, r - kBorder);
      double value = 0;
      if (fine) {
        value = value_at(image, p.x(), p.y());
      } else {
        for (const double x : {-1.0, 1.0}) {
          for (const double y : {-1.0, 1.0}) {
            const Eigen::Vector2d q = p + x * right + y * down;
            value += value_at(image, q.x(), q.y()) / 4;
          }
        }
      }
      row[c] = static_cast<std::uint8_t>(std::lround(value));
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
Describer::Describer(Describer&&) noexcept = default;
Describer& Describer::operator=(Describer&&) noexcept = default;

std::vector<std::optional<Descriptor>> Describer::describe(const GrayImage& image,
                                                           std::span<const ImagePatch> patches) {
  std::vector<std::optional<Descriptor>> result(patches.size());
  std::vector<std::size_t> inside;
  if (image.width < 2 || image.height < 2) return result;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i].step.allFinite() && is_inside(image, patches[i])) inside.push_back(i);
  }
  if (inside.empty()) return result;
  orb_->patches.create(kSide, kSide * static_cast<int>(inside.size()), CV_8UC1);
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

#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include <chasles/camera/image_frame.hpp>

namespace chasles::bench {

/// The reference: plain pyramidal KLT of OpenCV, 21 x 21 px, 4 levels, forward only, no prediction;
/// from frame to frame in camera 0 and, with two cameras, from there to camera 1. It detects new
/// corners (goodFeaturesToTrack) where tracks are missing.
class PlainKlt {
 public:
  explicit PlainKlt(int tracks) : tracks_(tracks) {}

  /// The images must stay valid until the next call.
  void process(const GrayImage& image, const GrayImage* other) {
    const cv::Mat now = mat(image);
    if (!last_.empty() && !points_.empty()) follow(now);
    refill(now);
    if (other) {
      cv::calcOpticalFlowPyrLK(now, mat(*other), points_, moved_, found_, error_, kWindow, kTop);
    }
    last_ = now;
  }
  std::size_t tracked() const { return tracked_; }  ///< from the last frame to this one

 private:
  inline static const cv::Size kWindow{21, 21};
  static constexpr int kTop = 3;  // levels above the image itself
  static constexpr double kDistance = 15;

  static cv::Mat mat(const GrayImage& image) {
    return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
  }

  void follow(const cv::Mat& now) {
    cv::calcOpticalFlowPyrLK(last_, now, points_, moved_, found_, error_, kWindow, kTop);
    points_.clear();
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      if (found_[i]) points_.push_back(moved_[i]);
    }
    tracked_ = points_.size();
  }

  // Away from the tracks, as many as are missing.
  void refill(const cv::Mat& image) {
    const int missing = tracks_ - static_cast<int>(points_.size());
    if (missing <= 0) return;
    cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
    for (const cv::Point2f& p : points_) {
      cv::circle(mask, p, static_cast<int>(kDistance), cv::Scalar(0), -1);
    }
    std::vector<cv::Point2f> added;
    cv::goodFeaturesToTrack(image, added, missing, 0.01, kDistance, mask);
    points_.insert(points_.end(), added.begin(), added.end());
  }

  int tracks_;
  std::size_t tracked_ = 0;
  cv::Mat last_;
  std::vector<cv::Point2f> points_, moved_;
  std::vector<uchar> found_;
  std::vector<float> error_;
};

}  // namespace chasles::bench

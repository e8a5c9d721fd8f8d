#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <chasles/calibrate/capture_guide.hpp>
#include <chasles/calibrate/growing_images.hpp>
#include <chasles/target/target_detector.hpp>

namespace chasles {

/// Searches the images of a target while another program writes them, the newest first, and says
/// what is seen and what is missing.
class LiveCapture {
 public:
  /// `candidates`: lenses, as of guiding_lens(). The folder need not be there yet. Throws as
  /// TargetDetector.
  LiveCapture(std::filesystem::path folder, const Target& target, std::vector<LensForm> candidates);

  /// Finds new images. A file must be the same in two polls.
  void poll() { images_.poll(); }
  /// Searches the images of one instant. False: none is waiting.
  bool search();

  std::size_t cameras() const { return images_.cameras(); }
  std::size_t skipped() const { return images_.waiting(); }  ///< instants, until now
  std::size_t recorded() const { return images_.names().size(); }
  std::pair<Time, Time> span() const;  ///< from the first to the last view; equal without one
  /// What the images that were searched last show, e.g. "cam0 120 of 144 corners, cam1 no target".
  std::string seen() const;
  /// How many views there are, and the focal lengths that they show.
  std::string found() const;
  /// As CaptureGuide::missing(); without images, that they are expected.
  std::vector<std::string> missing() const;

  /// For ViewOptions::known: what a file showed that has not changed since.
  const TargetDetection* known(const std::filesystem::path& file) const;

 private:
  struct Image {
    std::filesystem::path file;
    FileState state;
    TargetDetection detection;
    bool deep = false;  ///< 16 bits: a recording may use fewer of them
  };
  struct Shot {
    std::string name;
    std::vector<std::optional<Image>> images;  ///< of each camera
  };

  std::optional<Shot> searched(const GrowingImages::Shot& shot);
  void restart();
  void guide_by(const Shot& shot);

  GrowingImages images_;
  TargetDetector detector_;
  std::vector<LensForm> candidates_;
  std::vector<Camera> sizes_;  ///< of the cameras' first images
  std::vector<Shot> shots_;
  std::map<std::filesystem::path, std::pair<std::size_t, std::size_t>> places_;  ///< in shots_
  std::optional<CaptureGuide> guide_;
};

}  // namespace chasles

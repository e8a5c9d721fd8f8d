#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/png_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/masks.hpp>

namespace chasles {
namespace {

constexpr double kNearlyAll = 0.95;

// The file names of a setting, one per camera in order; empty: none.
std::vector<std::string> mask_files(const std::string& names, std::size_t cameras) {
  std::vector<std::string> files;
  std::string_view rest = names;
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    if (files.size() == cameras) {
      throw UsageError(fmt::format(
          "setting mask: '{}' names more files than there are cameras ({})", names, cameras));
    }
    files.emplace_back(trimmed(rest.substr(0, comma)));
    rest.remove_prefix(more ? comma + 1 : rest.size());
  }
  return files;
}

// Whether the file is a PNG with an alpha channel.
bool has_alpha(const std::string& file) {
  const std::string bytes = read_file(file);
  if (!bytes.starts_with(kPngStart)) return false;
  const std::uint32_t colour = png_header(bytes, file).colour;
  return colour == kGreyAlpha || colour == kColourAlpha;
}

std::string of_transparency(const std::string& file) {
  return has_alpha(file) ? "; its transparency does not count" : "";
}

GrayImage named_mask(const std::string& file, const Camera& camera) {
  return file.empty() ? GrayImage{} : read_mask(file, MaskKind::kBlackHides, camera);
}

}  // namespace

std::vector<GrayImage> read_masks(const std::string& names, const std::vector<Camera>& cameras) {
  if (trimmed(names).empty()) return {};
  std::vector<GrayImage> masks;
  for (const std::string& file : mask_files(names, cameras.size())) {
    masks.push_back(named_mask(file, cameras[masks.size()]));
  }
  masks.resize(cameras.size());
  return masks;
}

std::vector<GrayImage> masks_of(const std::string& names, const Recording& recording) {
  return trimmed(names).empty() ? recording.masks : read_masks(names, recording.cameras);
}

GrayImage read_mask(const std::filesystem::path& file, MaskKind kind, const Camera& camera) {
  const std::string name = file.string();
  GrayImage mask = read_image(file, {.width = camera.width, .height = camera.height});
  const bool inverted = kind == MaskKind::kWhiteHides;
  if (inverted) {
    for (std::uint8_t& pixel : mask.pixels) pixel = pixel > 0 ? 0 : 255;
  }
  if (covered_share(mask) < 1) return mask;
  const char* hides = inverted ? "white" : "black";
  throw InputError(
      fmt::format("{}: all pixels of this mask are {}, so that nothing would be tracked{}; "
                  "expected {} only where nothing is to be tracked: is it inverted?",
                  name, hides, of_transparency(name), hides));
}

double covered_share(const GrayImage& mask) {
  if (mask.pixels.empty()) return 0;
  const auto black = std::ranges::count(mask.pixels, std::uint8_t{0});
  return static_cast<double>(black) / static_cast<double>(mask.pixels.size());
}

std::vector<std::string> mask_remarks(const std::string& names,
                                      const std::vector<Camera>& cameras) {
  if (trimmed(names).empty()) return {};
  std::vector<std::string> remarks;
  const std::vector<std::string> files = mask_files(names, cameras.size());
  for (std::size_t c = 0; c < files.size(); ++c) {
    if (files[c].empty()) continue;
    const double covered = covered_share(named_mask(files[c], cameras[c]));
    if (covered > 0 && covered < kNearlyAll) continue;
    remarks.push_back(
        covered > 0
            ? fmt::format("the mask {} covers {:.1f} % of the image of cam{}", files[c],
                          100 * covered, c)
            : fmt::format("the mask {} covers nothing of the image of cam{}: no pixel is black{}",
                          files[c], c, of_transparency(files[c])));
  }
  return remarks;
}

}  // namespace chasles

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include <chasles/data/image_decode.hpp>
#include <chasles/data/masks.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {

std::vector<GrayImage> read_masks(const std::string& names, const std::vector<Camera>& cameras) {
  if (trimmed(names).empty()) return {};
  std::vector<GrayImage> masks;
  std::string_view rest = names;
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    const std::string name(trimmed(rest.substr(0, comma)));
    if (masks.size() == cameras.size()) {
      throw UsageError(
          fmt::format("setting mask: '{}' names more files than there are cameras ({})", names,
                      cameras.size()));
    }
    const Camera& camera = cameras[masks.size()];
    masks.push_back(name.empty()
                        ? GrayImage{}
                        : read_image(name, {.width = camera.width, .height = camera.height}));
    rest.remove_prefix(more ? comma + 1 : rest.size());
  }
  masks.resize(cameras.size());
  return masks;
}

}  // namespace chasles

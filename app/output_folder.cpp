#include "output_folder.hpp"

#include <chasles/data/text_file.hpp>

namespace chasles::app {

void prepare_output(const std::filesystem::path& folder) {
  make_folder(folder);
  const std::filesystem::path probe = folder / ".chasles-probe";
  write_file(probe, "probe");
  remove_file(probe);
}

}  // namespace chasles::app

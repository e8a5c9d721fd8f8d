#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/session/settings_io.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/street.hpp>

#include "arrays.hpp"
#include "lab.hpp"
#include "long_call.hpp"
#include "recordings.hpp"
#include "scene_options.hpp"
#include "setting_table.hpp"

namespace chasles::python {
namespace {

// Without the GIL.
Recording simulated(const std::string& scene, std::uint64_t run, bool images,
                    const std::vector<std::string>& sets) {
  if (app::is_inertial_scene(scene)) {
    app::SceneChoice choice;
    choice.name = scene;
    choice.sets = sets;
    choice.set_option = "setting";
    const InertialScene inertial = app::scene_from(choice);
    return images ? shared(render_inertial(inertial, run)) : simulate_inertial(inertial, run);
  }
  StreetSettings street = street_scene(scene);
  const SettingList list = list_of(street);
  for (const std::string& one : sets) assign(list, "setting", one);
  validate(street);
  if (images || run != 0) {
    throw UsageError(fmt::format(
        "{}: images and run are for scenes with an IMU; another run is another seed", scene));
  }
  return simulate_street(street);
}

Recording simulate(const std::string& scene, std::uint64_t run, bool images,
                   const py::object& progress, const py::kwargs& settings) {
  check_scene_keys("simulate", scene, settings);
  const std::vector<std::string> sets = assignments(settings);
  return LongCall(progress)([&] { return simulated(scene, run, images, sets); });
}

// Of scenes.
py::dict settings_of(const std::string& kind) {
  InertialSettings scene;
  StreetSettings street;
  return table_of(kind == "scene" ? list_of(scene) : list_of(street));
}

}  // namespace

void check_scene_keys(const std::string& function, const std::string& scene,
                      const py::dict& settings) {
  app::check_scene(scene);
  const bool inertial = app::is_inertial_scene(scene);
  InertialSettings of_scene;
  StreetSettings of_street;
  std::vector<std::string> known;
  for (const Setting& one : inertial ? list_of(of_scene) : list_of(of_street)) {
    known.push_back(one.name);
  }
  for (const std::string& assignment : assignments(settings)) {
    const std::string name = assignment.substr(0, assignment.find('='));
    if (std::ranges::find(known, name) != known.end()) continue;
    throw UsageError(fmt::format(
        "{}: unknown setting '{}' of the scene {}{}; expected one of chasles.settings(\"{}\")",
        function, name, scene, did_you_mean(name, known), inertial ? "scene" : "street"));
  }
}

void bind_simulation(py::module_& m) {
  m.def("simulate", &simulate, py::arg("scene"), py::kw_only(), py::arg("run") = 0,
        py::arg("images") = false, py::arg("progress") = py::none());
  m.def("settings", &settings_of, py::arg("kind"));
}

}  // namespace chasles::python

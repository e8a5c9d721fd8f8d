#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/base/interruption.hpp>
#include <chasles/check/check.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/check_motion_calibration.hpp>
#include <chasles/session/diagnosis.hpp>

#include "arrays.hpp"
#include "long_call.hpp"
#include "messages.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

CheckReport said_in_python(CheckReport report) {
  for (Finding& finding : report.findings) {
    finding.what = in_python(finding.what);
    finding.advice = in_python(finding.advice);
  }
  for (std::string& sentence : report.not_checked) sentence = in_python(sentence);
  return report;
}

// JSON and text.
std::pair<std::string, std::string> check(const Recording& recording, double seconds,
                                          bool calibration, const py::object& progress) {
  if (!(seconds >= 1 && seconds <= 1e5)) {
    throw py::value_error("seconds: expected a number from 1 to 100000");
  }
  return LongCall(progress).in_turn([&] {
    CheckReport report = diagnose(recording, seconds);
    if (calibration) {
      SessionOptions options;
      options.input.recording = recording.name;
      options.quiet = true;
      compare_with_motion(
          options, recording, [] { return interruption_wanted(); }, report);
      interruption_point();
    }
    report = said_in_python(std::move(report));
    Recording said = recording;
    for (std::string& remark : said.remarks) remark = in_python(remark);
    return std::pair(json_text(check_json(said, report)), check_text(said, report));
  });
}

}  // namespace

void bind_checks(py::module_& m) {
  m.def("check", &check, py::arg("recording"), py::arg("seconds"), py::arg("calibration"),
        py::arg("progress"));
}

}  // namespace chasles::python

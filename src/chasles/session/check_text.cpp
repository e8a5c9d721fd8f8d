#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/session/diagnosis.hpp>

namespace chasles {
namespace {

constexpr std::size_t kLine = 100;

// Three significant digits; 0 for a negligible number.
std::string number(double value) {
  if (std::abs(value) < 1e-3) return "0";
  return std::abs(value) >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? number(value) : fmt::format("{} {}", number(value), unit);
}

// The distinct subjects of the facts, in their order.
std::vector<std::string> subjects(const CheckReport& report) {
  std::vector<std::string> names;
  for (const Fact& fact : report.facts) {
    if (std::find(names.begin(), names.end(), fact.about) == names.end()) {
      names.push_back(fact.about);
    }
  }
  return names;
}

// The facts of one subject, broken into lines.
std::string facts_text(const CheckReport& report, const std::string& about) {
  std::string text, line = fmt::format("  {:<11}", about);
  const std::size_t indent = line.size();
  for (const Fact& fact : report.facts) {
    if (fact.about != about) continue;
    const std::string part = fmt::format("{} {}", fact.name, with_unit(fact.value, fact.unit));
    if (line.size() > indent && line.size() + part.size() + 2 > kLine) {
      text += line + ",\n";
      line.assign(indent, ' ');
    }
    line += (line.size() > indent ? ", " : "") + part;
  }
  return text + line + "\n";
}

std::string finding_text(const Finding& finding) {
  const std::string limit =
      finding.threshold == 0
          ? std::string()
          : fmt::format("limit {}; ", with_unit(finding.threshold, finding.unit));
  return fmt::format("  {:<9}{}: {}\n           {}{}\n", severity_name(finding.severity),
                     finding.about, finding.what, limit, finding.advice);
}

std::string heading(const CheckReport& report) {
  const std::size_t count = report.findings.size();
  if (count == 0) return "\nNo findings.\n";
  return fmt::format("\n{} finding{}:\n", count, count == 1 ? "" : "s");
}

}  // namespace

std::string check_text(const Recording& recording, const CheckReport& report) {
  std::string text = recording.name + "\n";
  for (const std::string& about : subjects(report)) text += facts_text(report, about);
  text += heading(report);
  for (const Finding& finding : report.findings) text += finding_text(finding);
  if (!report.not_checked.empty()) text += "\nNot checked:\n";
  for (const std::string& sentence : report.not_checked) text += "  " + sentence + "\n";
  if (!recording.remarks.empty()) text += "\nRemarks of the reader:\n";
  for (const std::string& sentence : recording.remarks) text += "  " + sentence + "\n";
  return text;
}

nlohmann::ordered_json check_json(const Recording& recording, const CheckReport& report) {
  nlohmann::ordered_json json{{"name", recording.name},
                              {"facts", nlohmann::ordered_json::object()},
                              {"findings", nlohmann::ordered_json::array()},
                              {"not_checked", report.not_checked},
                              {"remarks", recording.remarks}};
  for (const Fact& fact : report.facts) {
    json["facts"][fact.about][fact.name] = {{"value", fact.value}, {"unit", fact.unit}};
  }
  for (const Finding& finding : report.findings) {
    json["findings"].push_back({{"severity", severity_name(finding.severity)},
                                {"about", finding.about},
                                {"what", finding.what},
                                {"value", finding.value},
                                {"threshold", finding.threshold},
                                {"unit", finding.unit},
                                {"advice", finding.advice}});
  }
  return json;
}

}  // namespace chasles

#include <algorithm>
#include <map>
#include <sstream>
#include <unistd.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/batch_folder.hpp>
#include <chasles/many/verdict.hpp>
#include <chasles/report/batch_page.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPlan = "plan.json";

// "estimator: 'filter' and 'batch'" for the first entry that differs.
std::string first_difference(const Json& a, const Json& b) {
  for (const auto& [key, value] : a.items()) {
    const Json other = b.value(key, Json(nullptr));
    if (other != value) return fmt::format("{}: {} and {}", key, other.dump(), value.dump());
  }
  return "its entries";
}

bool is_record(const Json& record) {
  const auto has = [&](const char* name, bool (Json::*is)() const noexcept) {
    return record.is_object() && record.contains(name) && (record.at(name).*is)();
  };
  return has("verdict", &Json::is_string) && has("reasons", &Json::is_array) &&
         has("options", &Json::is_object) && has("name", &Json::is_string);
}

void expect_same_plan(const fs::path& file, const Json& plan) {
  const Json other = Json::parse(read_text(file), nullptr, false);
  if (!other.is_object()) {
    throw InputError(
        fmt::format("{}: found no JSON object, expected the plan of a batch", file.string()));
  }
  if (other == plan) return;
  throw UsageError(
      fmt::format("{}: the batch there has another plan ({}); expected the same "
                  "options, or another folder with -o",
                  file.string(), first_difference(plan, other)));
}

// Creates a file with these bytes, whole; false where there is one already.
bool create_file(const fs::path& file, const std::string& bytes) {
  const fs::path part = fmt::format("{}.{}.part", file.string(), getpid());
  write_file(part, bytes);
  std::error_code error;
  fs::create_hard_link(part, file, error);
  fs::remove(part);
  if (!error) return true;
  if (fs::exists(file)) return false;
  replace_file(file, bytes);  // of a file system without links
  return true;
}

// The middle one of those that the run has kept; none: empty.
std::string picture_in(const fs::path& run) {
  std::vector<std::string> pictures = pictures_of(run);
  if (pictures.empty()) return "";
  std::ranges::sort(pictures);
  return read_file(run / pictures[pictures.size() / 2]);
}

double number_or_0(const Json& record, const char* name) {
  const auto found = record.find(name);
  return found != record.end() && found->is_number() ? found->get<double>() : 0;
}

Json summary_of(const std::vector<Json>& records, const Json& plan) {
  std::map<std::string, int> verdicts, reasons;
  double seconds = 0, length = 0;
  for (const Json& record : records) {
    ++verdicts[record.at("verdict").get<std::string>()];
    for (const Json& reason : record.at("reasons")) {
      ++reasons[reason.at("reason").get<std::string>()];
    }
    seconds += number_or_0(record, "recorded_seconds");
    length += number_or_0(record, "length_m");
  }
  Json summary{{"recordings", records.size()}, {"verdicts", Json::object()}};
  for (const Verdict verdict : {Verdict::kUse, Verdict::kCheck, Verdict::kNo}) {
    summary["verdicts"][name_of(verdict)] = verdicts[name_of(verdict)];
  }
  summary["reasons"] = Json::object();
  for (const ReasonKind& kind : reason_kinds()) {
    if (reasons.contains(kind.name)) summary["reasons"][kind.name] = reasons.at(kind.name);
  }
  summary["recorded_seconds"] = seconds;
  summary["length_m"] = length;
  summary["plan"] = plan;
  return summary;
}

}  // namespace

BatchFolder::BatchFolder(fs::path folder, const Json& plan, const Shard& shard, bool resume)
    : folder_(std::move(folder)), plan_(plan) {
  const fs::path plan_file = folder_ / kPlan;
  if (fs::exists(plan_file)) {
    if (!resume && shard.is_whole()) {
      throw UsageError(
          fmt::format("-o: {} has a batch already; --resume continues it", folder_.string()));
    }
    expect_same_plan(plan_file, plan_);
  }
  for (const char* part : {"runs", "verdicts", "timing"}) prepare_output(folder_ / part);
  if (shard.is_whole()) {
    lock_.emplace(folder_);
  } else {
    lock_.emplace(folder_ / fmt::format(".shard-{}-of-{}", shard.part, shard.parts), true);
  }
  // Another part may have begun meanwhile, with other options.
  if (!create_file(plan_file, json_text(plan_, 2) + "\n")) expect_same_plan(plan_file, plan_);
}

fs::path BatchFolder::run_of(const BatchItem& item) const { return folder_ / "runs" / item.name; }

fs::path BatchFolder::record_of(const BatchItem& item) const {
  return folder_ / "verdicts" / (item.name + ".json");
}

std::optional<Json> BatchFolder::record(const BatchItem& item) const {
  const fs::path file = record_of(item);
  if (!fs::exists(file)) return std::nullopt;
  const Json record = Json::parse(read_text(file), nullptr, false);
  if (!is_record(record)) {
    throw InputError(
        fmt::format("{}: found no record of a recording; remove it to run the "
                    "recording again",
                    file.string()));
  }
  if (const std::string other = record.value("recording", ""); other != item.said_source()) {
    throw UsageError(
        fmt::format("{}: is of {}, and {} has the same name; give it another in the "
                    "list of --manifest",
                    file.string(), other, item.said_source()));
  }
  if (record.at("options") != item.options_json()) {
    throw UsageError(
        fmt::format("{}: was made with the options {}, and the list says {}; remove "
                    "it to run the recording again",
                    file.string(), record.at("options").dump(), item.options_json().dump()));
  }
  return record;
}

void BatchFolder::add(const BatchItem& item, const Json& record, const Json& timing) {
  replace_file(folder_ / "timing" / (item.name + ".json"), json_text(timing) + "\n");
  replace_file(record_of(item), json_text(record) + "\n");
}

Json BatchFolder::finish(std::span<const BatchItem> items, const Json& difference) {
  std::vector<Json> records;
  std::string lines;
  std::vector<BatchRow> rows;
  for (const BatchItem& item : items) {
    Json record = *this->record(item);
    rows.push_back({record, picture_in(run_of(item))});
    record.erase("sketch");
    lines += json_text(record) + "\n";
    records.push_back(std::move(record));
  }
  const Json summary = summary_of(records, plan_);
  replace_file(folder_ / "verdicts.jsonl", lines);
  if (difference.is_null()) {
    remove_file(folder_ / "difference.json");
  } else {
    replace_file(folder_ / "difference.json", json_text(difference, 2) + "\n");
  }
  replace_file(folder_ / "page.html", batch_page(summary, rows, difference));
  replace_file(folder_ / "summary.json", json_text(summary, 2) + "\n");
  return summary;
}

std::vector<Json> read_verdicts(const fs::path& folder) {
  const fs::path file = folder / "verdicts.jsonl";
  std::istringstream lines(read_text(file));
  std::vector<Json> records;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    Json record = Json::parse(line, nullptr, false);
    if (!is_record(record)) {
      throw InputError(fmt::format("{}:{}: found '{}', expected the record of a recording",
                                   file.string(), number, line.substr(0, 60)));
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace chasles

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <system_error>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/folder_replacement.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/run_folder/run_text.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr const char *kStates = "states.csv", *kLandmarks = "landmarks.csv",
                     *kSummary = "summary.json", *kTruth = "truth.tum",
                     *kDeadReckoning = "dead_reckoning.tum";

int open_folder(const fs::path& folder) {
  return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

/// Whether another process has locked it. On a file system without locks: false.
bool is_taken(int folder, int lock) {
  return ::flock(folder, lock | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

fs::path part_of(const fs::path& file) { return file.string() + ".part"; }

// Returns the number of bytes.
std::size_t append(const fs::path& file, const std::function<bool(std::string& part)>& next) {
  std::ofstream stream(file, std::ios::binary | std::ios::app);
  std::size_t bytes = 0;
  for (std::string part; next(part); part.clear()) {
    stream << part;
    bytes += part.size();
  }
  stream << std::flush;
  if (!stream) throw UsageError(fmt::format("{}: cannot be written", file.string()));
  sync_to_disk(file);
  return bytes;
}

}  // namespace

fs::path growing_folder(const fs::path& run_folder) { return run_folder / "growing"; }

bool is_growing(const fs::path& run_folder) {
  const int folder = open_folder(growing_folder(run_folder));
  if (folder < 0) return false;
  const bool held = is_taken(folder, LOCK_SH);
  ::close(folder);
  return held;
}

GrowingRun::GrowingRun(const fs::path& run_folder) : GrowingRun(run_folder, Pace{}) {}

GrowingRun::GrowingRun(const fs::path& run_folder, Pace pace)
    : folder_(growing_folder(run_folder)), pace_(pace) {
  make_folder(folder_);
  lock_ = open_folder(folder_);
  if (lock_ < 0) {
    throw UsageError(fmt::format("{}: cannot be opened as a folder", folder_.string()));
  }
  bool taken = is_taken(lock_, LOCK_EX);
  // A process that only checks the lock holds it for an instant.
  for (int tries = 0; taken && tries < 5; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    taken = is_taken(lock_, LOCK_EX);
  }
  if (taken) {
    ::close(lock_);
    throw UsageError(
        fmt::format("{}: another run is being written into it; wait for its end, or "
                    "name another folder",
                    run_folder.string()));
  }
  remove_files();
  discard_unfinished(run_folder);
}

GrowingRun::~GrowingRun() {
  if (!readable_) remove_files();
  std::error_code not_empty;
  fs::remove(folder_, not_empty);
  ::close(lock_);
}

void GrowingRun::end() { readable_ = false; }

// Removes its own files only; other files in the folder are kept. Without the summary, the first,
// the others are no run.
void GrowingRun::remove_files() const {
  std::error_code ignored;
  for (const char* name : {kSummary, kStates, kLandmarks, kTruth, kDeadReckoning}) {
    fs::remove(folder_ / name, ignored);
    fs::remove(part_of(folder_ / name), ignored);
  }
}

void GrowingRun::begin(const Run& header, const nlohmann::ordered_json& summary) {
  summary_ = std::make_unique<nlohmann::ordered_json>(summary);
  (*summary_)["name"] = header.name;
  next_ = Clock::now() + pace_.first;
}

void GrowingRun::extend(const Run& run, const std::function<std::vector<RunLandmark>()>& map) {
  const Clock::time_point start = Clock::now();
  if (given_up_ || start < next_ || run.states.size() == written_) return;
  try {
    write(run, map());
  } catch (const std::exception&) {  // a full disk: the end of the run reports it
    given_up_ = true;
  }
  const Clock::time_point end = Clock::now();
  next_ = end + std::max<Clock::duration>(pace_.between, pace_.share * (end - start));
}

void GrowingRun::write(const Run& run, const std::vector<RunLandmark>& landmarks) {
  const bool first = written_ == 0;
  if (first && !run.truth.empty()) {
    write_tum(run.truth, folder_ / kTruth);
    sync_to_disk(folder_ / kTruth);
  }
  if (first && !run.dead_reckoning.empty()) {
    write_tum(run.dead_reckoning, folder_ / kDeadReckoning);
    sync_to_disk(folder_ / kDeadReckoning);
  }
  bytes_ += append(folder_ / kStates, state_parts(run, written_));
  written_ = run.states.size();
  replace_file(folder_ / kLandmarks, landmark_parts(landmarks));
  // The last file: with it the folder is readable, and it states how much of states.csv is whole.
  (*summary_)[kStatesBytes] = bytes_;
  replace_file(folder_ / kSummary, json_text(*summary_, 2) + "\n");
  sync_to_disk(folder_);
  readable_ = true;
}

}  // namespace chasles

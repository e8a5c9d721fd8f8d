#pragma once

#include <string>
#include <vector>

namespace chasles::app {

/// Lines on stderr that change while a command works: on a terminal they are written over; else all
/// in one line, when they have changed.
class LiveText {
 public:
  explicit LiveText(bool quiet);
  LiveText(const LiveText&) = delete;
  LiveText& operator=(const LiveText&) = delete;
  ~LiveText();  ///< ends the lines

  void show(const std::vector<std::string>& lines);

 private:
  bool quiet_, is_terminal_;
  std::size_t shown_ = 0;  ///< lines on the terminal
  std::string last_;
};

}  // namespace chasles::app

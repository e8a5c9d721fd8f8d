#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <xmlrpcpp/XmlRpcValue.h>

#include "outgoing.hpp"
#include "raw_message.hpp"

namespace chasles::ros1 {

enum class LogLevel { kInfo, kWarning, kError };

/// The node's side of ROS 1: topics, services, parameters and the log. Its source is C++17, as the
/// headers of ROS 1 messages need it.
class Transport {
 public:
  using Handler = std::function<void(const RawMessage&)>;
  /// Success, and a message.
  using Service = std::function<std::pair<bool, std::string>()>;

  /// Connects to the master: waits until there is one. Takes ROS's arguments (remappings, __name).
  /// SIGINT and SIGTERM end wait(), and nothing else.
  Transport(int argc, char** argv, const std::string& name);
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  ~Transport();

  /// The private parameters; invalid where there are none.
  XmlRpc::XmlRpcValue parameters() const;
  /// A topic with all remappings.
  std::string resolved(const std::string& topic) const;
  const std::string& name() const;  ///< of the node, with its namespace

  /// Handles the messages of a topic, of any type, on a thread of its own. `queue`: messages that
  /// may wait; one more, and the oldest is lost. 0: all wait.
  void subscribe(const std::string& topic, std::uint32_t queue, Handler handler);
  /// A service std_srvs/Trigger below the node's name.
  void serve(const std::string& name, Service service);
  /// Calls the function again and again, by the wall clock.
  void every(double seconds, std::function<void()> work);

  // Topics below the node's name; tf and diagnostics are global. Any thread may publish.
  void publish_odometry(const OutOdometry& odometry);                    ///< odometry
  void publish_frame_odometry(const OutOdometry& odometry);              ///< frame_odometry
  void publish_pose(const OutPoseWithCovariance& pose);                  ///< pose
  void publish_pose_in_map(const OutPoseWithCovariance& pose);           ///< pose_in_map
  void publish_path(const OutPath& path);                                ///< path
  void publish_points(const OutPoints& points);                          ///< points
  void publish_transforms(const std::vector<OutTransform>& transforms);  ///< /tf
  void publish_diagnosis(const OutDiagnosis& diagnosis);                 ///< /diagnostics
  bool wants_path() const;                                               ///< has a subscriber
  bool wants_points() const;                                             ///< likewise

  void log(LogLevel level, const std::string& text) const;

  /// Handles messages until a signal, or a shutdown by the master. Then no handler runs any more;
  /// with `drain` only when what has come is handled. Publishing goes on until the destructor.
  void wait(bool drain);
  void stop();  ///< as a signal

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace chasles::ros1

#pragma once

#include <string>

namespace chasles::bridge {

/// The largest number of a DDS domain whose ports exist.
inline constexpr int kLastDomain = 232;

/// The configuration of Cyclone DDS for a network:
/// - "loopback": this machine alone, over 127.0.0.1, without multicast;
/// - "host": the processes of this machine, by its own addresses, without multicast: for peers that
///   do not name 127.0.0.1 as theirs, as nodes of ROS 2 with Fast DDS;
/// - "any": the interface that Cyclone DDS chooses, with multicast for discovery, as ROS 2;
/// - else the name or the address of an interface, with multicast for discovery.
/// Throws UsageError for a text that is no name.
std::string network_configuration(const std::string& network);

}  // namespace chasles::bridge

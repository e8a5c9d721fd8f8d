#include <algorithm>
#include <array>
#include <cstring>
#include <ifaddrs.h>
#include <stdexcept>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/random.h>

#include <chasles/live/gate.hpp>

namespace chasles {
namespace {

bool is_version_4(const std::string& address) {
  in_addr parsed{};
  return ::inet_pton(AF_INET, address.c_str(), &parsed) == 1;
}

bool is_version_6(const std::string& address) {
  in6_addr parsed{};
  return ::inet_pton(AF_INET6, address.c_str(), &parsed) == 1;
}

/// An address in the notation of URLs.
std::string bracketed(std::string_view address) {
  return address.find(':') == std::string_view::npos ? std::string(address)
                                                     : fmt::format("[{}]", address);
}

/// The Host header without the port, if the port is the server's; an absent port is 80.
std::string_view without_port(std::string_view host, std::uint16_t port) {
  const std::string end = fmt::format(":{}", port);
  if (host.ends_with(end)) return host.substr(0, host.size() - end.size());
  const bool has_port = host.find_last_of(':') != std::string_view::npos && !host.ends_with(']');
  return port == 80 && !has_port ? host : std::string_view{};
}

/// The IPv4 addresses of the machine.
std::vector<std::string> own_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return addresses;
  for (const ifaddrs* own = first; own != nullptr; own = own->ifa_next) {
    if (own->ifa_addr == nullptr || own->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, own->ifa_addr, sizeof(address));
    std::array<char, INET_ADDRSTRLEN> text{};
    ::inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
    addresses.emplace_back(text.data());
  }
  ::freeifaddrs(first);
  return addresses;
}

/// The value of ?token=…; empty where there is none.
std::string_view token_of(std::string_view query) {
  static constexpr std::string_view kName = "token=";
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    if (pair.starts_with(kName)) return pair.substr(kName.size());
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
  }
  return {};
}

}  // namespace

std::string random_token() {
  std::array<std::uint8_t, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("getrandom gives no random bytes");
  }
  std::string token;
  for (const std::uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char differences = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    differences = static_cast<unsigned char>(differences | (a[i] ^ b[i]));
  }
  return differences == 0;
}

bool is_loopback(std::string_view address) {
  const std::string text(address);
  return text == "::1" || (text.starts_with("127.") && is_version_4(text));
}

std::vector<std::string> urls(const Gate& gate) {
  const bool all = gate.address == "0.0.0.0" || gate.address == "::";
  std::vector<std::string> addresses = all ? own_addresses() : std::vector<std::string>();
  if (addresses.empty()) addresses = {gate.address};
  const std::string query = gate.token.empty() ? "" : "?token=" + gate.token;
  for (std::string& address : addresses) {
    address = fmt::format("http://{}:{}/{}", bracketed(address), gate.port, query);
  }
  return addresses;
}

bool knows_host(const Gate& gate, std::string_view host) {
  const std::string name(without_port(host, gate.port));
  if (name.empty()) return false;
  if (name == "localhost" || name == bracketed(gate.address)) return true;
  if (is_loopback(gate.address)) return name == "127.0.0.1" || name == "[::1]";
  if (name.starts_with('[') && name.ends_with(']')) {
    return is_version_6(name.substr(1, name.size() - 2));
  }
  return is_version_4(name);
}

Answer decide(const Gate& gate, const Request& request) {
  if (request.repeated || !knows_host(gate, request.host)) return Answer::kForbidden;
  if (!request.origin.empty() && request.origin != fmt::format("http://{}", request.host)) {
    return Answer::kForbidden;
  }
  const std::size_t question = request.target.find('?');
  const std::string_view path = request.target.substr(0, question);
  const std::string_view query =
      question == std::string_view::npos ? "" : request.target.substr(question + 1);
  if (!gate.token.empty() && !same_secret(token_of(query), gate.token)) return Answer::kForbidden;
  if (request.method != "GET") return Answer::kNotFound;
  if (path == "/" && !request.upgrade) return Answer::kPage;
  if (path == "/live" && request.upgrade) return Answer::kSocket;
  return Answer::kNotFound;
}

}  // namespace chasles

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// A random token of 128 bits as 32 hexadecimal digits, from the operating system (getrandom).
std::string random_token();

/// Whether two texts are equal. The time taken depends only on their lengths.
bool same_secret(std::string_view a, std::string_view b);

/// Whether a numeric address is a loopback address: 127.0.0.0/8 or ::1.
bool is_loopback(std::string_view address);

/// The access control of the live server.
struct Gate {
  std::string address;     ///< address that the server listens on
  std::uint16_t port = 0;  ///< port that the server listens on
  std::string token;       ///< required in the URL as ?token=…; empty: no token required
};

/// http://ADDRESS:PORT/, with the token if there is one. If the server listens on all addresses of
/// the machine, one URL for each.
std::vector<std::string> urls(const Gate& gate);

/// The kind of answer to a request.
enum class Answer {
  kPage,       ///< GET /
  kSocket,     ///< GET /live with an upgrade to WebSocket
  kNotFound,   ///< everything else: the server serves no files
  kForbidden,  ///< a foreign or repeated Host or Origin, a missing or wrong token
};

/// The parts of a request that determine the answer.
struct Request {
  std::string_view method, target;
  std::string_view host;  ///< the header Host; empty: absent
  std::string_view
      origin;  ///< the header Origin; empty: absent, as for programs other than browsers
  std::string_view protocols = {};  ///< the header Sec-WebSocket-Protocol; empty: absent
  bool upgrade = false;             ///< requests a WebSocket
  bool repeated = false;  ///< has a second Host or Origin, whose values a proxy may see instead
};

/// Whether a Host header is this server's, against DNS rebinding. On loopback it is localhost,
/// 127.0.0.1 or [::1] with the port. Elsewhere it is any numeric address (an attacker can own a
/// name), localhost, or the address as given.
bool knows_host(const Gate& gate, std::string_view host);

/// Determines the answer to a request. The gate must know its Host. An Origin, if present, must be
/// http:// and that Host.
Answer decide(const Gate& gate, const Request& request);

}  // namespace chasles

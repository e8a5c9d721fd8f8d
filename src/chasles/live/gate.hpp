#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// A random token of 128 bits as 32 hexadecimal digits, from the system's generator (getrandom).
std::string random_token();

/// Whether two texts are the same; how long that takes tells nothing but their lengths.
bool same_secret(std::string_view a, std::string_view b);

/// Whether a numeric address is one that only this machine reaches: 127.0.0.0/8 or ::1.
bool is_loopback(std::string_view address);

/// What stands at the door of the live server.
struct Gate {
  std::string address;     ///< that the server listens on
  std::uint16_t port = 0;  ///< the same
  std::string token;       ///< that the URL must carry as ?token=…; empty: none is asked for
};

/// http://ADDRESS:PORT/, with the token where there is one; of a server that listens on all of the
/// machine's addresses one for each of them.
std::vector<std::string> urls(const Gate& gate);

/// What a request is answered with.
enum class Answer {
  kPage,       ///< GET /
  kSocket,     ///< GET /live with an upgrade to WebSocket
  kNotFound,   ///< everything else: the server knows no files
  kForbidden,  ///< a foreign Host or Origin, no token or a wrong one
};

/// The parts of a request that decide.
struct Request {
  std::string_view method, target;
  std::string_view host;  ///< the header Host; empty: absent
  std::string_view
      origin;            ///< the header Origin; empty: absent, as with programs that are no browser
  bool upgrade = false;  ///< asks for a WebSocket
};

/// Against DNS rebinding the Host has to be this server's: on loopback localhost, 127.0.0.1 or
/// [::1] with its port; elsewhere any numeric address (a name could be anybody's), localhost, or
/// the address as it was given. An Origin, where there is one, has to be http:// and that Host.
Answer decide(const Gate& gate, const Request& request);

}  // namespace chasles

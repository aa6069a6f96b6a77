// Who may connect. The server tells and takes no orders, but what it tells are camera images:
// web pages of others must not read them through the browser of someone who happens to visit them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gw::view {

struct AccessRules {
  std::string token;                         // empty: none is asked for
  std::vector<std::string> allowed_hosts;    // names beyond localhost and IP addresses
  std::vector<std::string> allowed_origins;  // of web pages beyond our own
};

// The Host header names this machine by an address, as localhost, or by an allowed name. A foreign
// name that was made to resolve to this machine (DNS rebinding) is refused.
bool HostIsAllowed(std::string_view host, const AccessRules& rules);

// The Origin header of a WebSocket: absent (programs), of a page that this server sent (same host),
// of a page on this machine, of a desktop program (no web address), or allowed.
bool OriginIsAllowed(std::string_view origin, std::string_view host, const AccessRules& rules);

// target: "/path?token=...". Compared in a time that does not depend on where they differ.
bool TokenIsRight(std::string_view target, const AccessRules& rules);

// "127.0.0.0/8", "::1" or "localhost": reachable from this machine alone.
bool IsLoopback(std::string_view host_name);

// "localhost:8765" -> "localhost", "[::1]:80" -> "::1".
std::string HostName(std::string_view host);

}  // namespace gw::view

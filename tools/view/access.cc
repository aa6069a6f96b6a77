#include "tools/view/access.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>

namespace gw::view {
namespace {

bool IsAddress(const std::string& name) {
  unsigned char buffer[16];
  return ::inet_pton(AF_INET, name.c_str(), buffer) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), buffer) == 1;
}

bool Contains(const std::vector<std::string>& list, std::string_view value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

}  // namespace

std::string HostName(std::string_view host) {
  if (host.starts_with('[')) {
    const size_t end = host.find(']');
    return std::string(host.substr(1, end == std::string_view::npos ? end : end - 1));
  }
  std::string name(host.substr(0, host.find(':')));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

bool IsLoopback(std::string_view host_name) {
  return host_name == "localhost" || host_name == "::1" ||
         (host_name.starts_with("127.") && IsAddress(std::string(host_name)));
}

bool HostIsAllowed(std::string_view host, const AccessRules& rules) {
  const std::string name = HostName(host);
  return name == "localhost" || IsAddress(name) || Contains(rules.allowed_hosts, name);
}

bool OriginIsAllowed(std::string_view origin, std::string_view host, const AccessRules& rules) {
  if (origin.empty()) return true;
  if (Contains(rules.allowed_origins, origin)) return true;
  const size_t at = origin.find("://");
  if (at == std::string_view::npos) return false;  // "null": a page that hides where it is from
  const std::string_view scheme = origin.substr(0, at);
  if (scheme != "http" && scheme != "https") return true;
  const std::string_view origin_host = origin.substr(at + 3);
  return origin_host == host || IsLoopback(HostName(origin_host));
}

bool TokenIsRight(std::string_view target, const AccessRules& rules) {
  if (rules.token.empty()) return true;
  const size_t query = target.find('?');
  if (query == std::string_view::npos) return false;
  std::string_view rest = target.substr(query + 1);
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    if (!part.starts_with("token=")) continue;
    const std::string_view given = part.substr(6);
    unsigned difference = given.size() != rules.token.size();
    for (size_t i = 0; i < given.size(); ++i) {
      difference |= static_cast<unsigned char>(given[i] ^ rules.token[i % rules.token.size()]);
    }
    return difference == 0;
  }
  return false;
}

}  // namespace gw::view

#include "common/process/sd_notify.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "common/process/file_handle.h"

namespace gw::process {

SdNotify::SdNotify() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  if (path != nullptr && std::strlen(path) < sizeof(sockaddr_un::sun_path)) socket_path_ = path;
}

void SdNotify::Send(std::string_view state) const {
  if (!active()) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, socket_path_.data(), socket_path_.size());
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // abstract name space
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_path_.size());
  const FileHandle fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  // Nothing to be done about failure: systemd then acts as if we were stuck, which is right.
  (void)::sendto(fd.get(), state.data(), state.size(), MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&address), length);
}

}  // namespace gw::process

// Tests: a client that speaks HTTP and WebSocket by hand, so that it can also do it wrong.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <optional>
#include <string>

namespace gw::view::testing {

class TestClient {
 public:
  explicit TestClient(uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~TestClient() { ::close(fd_); }
  TestClient(const TestClient&) = delete;
  TestClient& operator=(const TestClient&) = delete;

  bool connected() const { return connected_; }
  // False when the server has closed the connection.
  bool Send(const std::string& bytes) {
    for (size_t sent = 0; sent < bytes.size();) {
      const ssize_t n = ::send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<size_t>(n);
    }
    return true;
  }
  // At least one byte; empty: closed, or nothing within the time.
  std::string Receive(int timeout_ms = 5000) {
    pollfd poll{fd_, POLLIN, 0};
    if (::poll(&poll, 1, timeout_ms) <= 0) return "";
    char buffer[65536];
    const ssize_t n = ::recv(fd_, buffer, sizeof(buffer), 0);
    return n > 0 ? std::string(buffer, static_cast<size_t>(n)) : "";
  }
  std::string ReceiveAll(int timeout_ms = 5000) {
    std::string all;
    for (std::string part; !(part = Receive(timeout_ms)).empty();) all += part;
    return all;
  }
  // True when the server closes within the time, whatever it sends before.
  bool IsClosed(int timeout_ms = 5000) {
    pollfd poll{fd_, POLLIN, 0};
    char buffer[65536];
    while (::poll(&poll, 1, timeout_ms) > 0) {
      if (::recv(fd_, buffer, sizeof(buffer), 0) <= 0) return true;
    }
    return false;
  }

  std::string Get(const std::string& target, const std::string& host = "localhost") {
    Send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
    return ReceiveAll();
  }

  // The server's answer to a WebSocket handshake.
  std::string Upgrade(const std::string& target = "/", const std::string& more = kProtocol,
                      const std::string& host = "localhost") {
    Send("GET " + target + " HTTP/1.1\r\nHost: " + host +
         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         more + "\r\n");
    std::string answer;
    while (answer.find("\r\n\r\n") == std::string::npos) {
      const std::string part = Receive();
      if (part.empty()) break;
      answer += part;
    }
    const size_t end = answer.find("\r\n\r\n");
    if (end != std::string::npos) frames_ = answer.substr(end + 4);
    return answer.substr(0, end);
  }

  // A frame of a client, masked with zeros. opcode 1: text, 2: binary.
  static std::string Frame(const std::string& payload, int opcode = 1) {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80 | payload.size());
    } else {
      frame += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8) {
        frame += static_cast<char>(payload.size() >> shift);
      }
    }
    return frame + std::string(4, '\0') + payload;
  }

  // The payload of the next frame; absent: closed, or nothing within the time.
  std::optional<std::string> NextFrame(int timeout_ms = 5000) {
    while (true) {
      if (auto payload = TakeFrame()) return payload;
      const std::string part = Receive(timeout_ms);
      if (part.empty()) return std::nullopt;
      frames_ += part;
    }
  }

  static constexpr char kProtocol[] = "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n";

 private:
  std::optional<std::string> TakeFrame() {
    if (frames_.size() < 2) return std::nullopt;
    const auto byte = [this](size_t i) { return static_cast<uint8_t>(frames_[i]); };
    size_t head = 2, length = byte(1) & 127;
    const size_t wide = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (frames_.size() < 2 + wide) return std::nullopt;
    if (wide > 0) length = 0;
    for (size_t i = 0; i < wide; ++i) length = length << 8 | byte(head++);
    if (frames_.size() < head + length) return std::nullopt;
    std::string payload = frames_.substr(head, length);
    frames_.erase(0, head + length);
    return payload;
  }

  int fd_;
  bool connected_ = false;
  std::string frames_;
};

}  // namespace gw::view::testing

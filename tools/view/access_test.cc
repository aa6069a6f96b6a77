#include "tools/view/access.h"

#include <gtest/gtest.h>

namespace gw::view {
namespace {

TEST(Access, HostsAreAddressesLocalhostAndAllowedNames) {
  AccessRules rules;
  for (const char* host :
       {"localhost:8765", "127.0.0.1:8765", "[::1]:8765", "192.168.1.5", "LOCALHOST"}) {
    EXPECT_TRUE(HostIsAllowed(host, rules)) << host;
  }
  for (const char* host : {"evil.example:8765", "", "localhost.evil.example", "127.0.0.1.evil"}) {
    EXPECT_FALSE(HostIsAllowed(host, rules)) << host;
  }
  rules.allowed_hosts = {"robot.example"};
  EXPECT_TRUE(HostIsAllowed("robot.example:443", rules));
}

TEST(Access, PagesOfOthersMayNotConnect) {
  AccessRules rules;
  const char* host = "192.168.1.5:8765";
  for (const char* origin :
       {"", "http://192.168.1.5:8765", "http://localhost:3000", "file://", "lichtblick://app"}) {
    EXPECT_TRUE(OriginIsAllowed(origin, host, rules)) << origin;
  }
  for (const char* origin :
       {"null", "http://evil.example", "https://localhost.evil.example", "http://192.168.1.5:9"}) {
    EXPECT_FALSE(OriginIsAllowed(origin, host, rules)) << origin;
  }
  rules.allowed_origins = {"https://app.foxglove.dev"};
  EXPECT_TRUE(OriginIsAllowed("https://app.foxglove.dev", host, rules));
}

TEST(Access, TheTokenIsAskedForWhenThereIsOne) {
  AccessRules rules;
  EXPECT_TRUE(TokenIsRight("/", rules));
  rules.token = "0123456789abcdef";
  EXPECT_TRUE(TokenIsRight("/?token=0123456789abcdef", rules));
  EXPECT_TRUE(TokenIsRight("/?a=b&token=0123456789abcdef&c", rules));
  for (const char* target : {"/", "/?", "/?token=", "/?token=0123456789abcdeF",
                             "/?token=0123456789abcdef0", "/?nottoken=0123456789abcdef"}) {
    EXPECT_FALSE(TokenIsRight(target, rules)) << target;
  }
}

TEST(Access, LoopbackIsThisMachine) {
  EXPECT_TRUE(IsLoopback("127.0.0.1"));
  EXPECT_TRUE(IsLoopback("::1"));
  EXPECT_FALSE(IsLoopback("0.0.0.0"));
  EXPECT_FALSE(IsLoopback("127.evil.example"));
}

}  // namespace
}  // namespace gw::view

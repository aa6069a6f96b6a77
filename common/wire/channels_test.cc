// docs/channels.md is the table of channels.h for people, with the fingerprints of the types: a
// type that changes makes old logs unreadable, so its line must be changed knowingly.
#include "common/wire/channels.h"

#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "common/wire/wire.h"

namespace gw::wire {
namespace {

std::string PolicyName(QueuePolicy policy) {
  switch (policy) {
    case QueuePolicy::kNewest:
      return "newest";
    case QueuePolicy::kEvery:
      return "every";
    case QueuePolicy::kReliable:
      return "reliable";
  }
  return "";
}

std::string Table() {
  std::ostringstream table;
  table << "| channel | type | from | rate | policy | queue | fingerprint |\n"
           "| --- | --- | --- | --- | --- | --- | --- |\n";
  for (const Channel& channel : kChannels) {
    char fingerprint[20];
    std::snprintf(fingerprint, sizeof(fingerprint), "%016" PRIx64,
                  static_cast<uint64_t>(FingerprintOf(channel.type)));
    table << "| " << channel.name << " | [" << channel.type << "](../lcmtypes/" << channel.type
          << ".lcm) | " << channel.publisher << " | " << channel.rate << " | "
          << PolicyName(channel.policy) << " | " << channel.queue_capacity << " | `" << fingerprint
          << "` |\n";
  }
  return table.str();
}

TEST(Channels, TheDocumentedTableIsTheOneInTheCode) {
  std::ifstream file(std::string(GW_SOURCE_DIR) + "/docs/channels.md");
  ASSERT_TRUE(file) << "docs/channels.md is missing";
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find(Table()), std::string::npos)
      << "docs/channels.md does not hold this table:\n\n"
      << Table();
}

TEST(Channels, NamesAndTypesAreUsable) {
  for (const Channel& channel : kChannels) {
    EXPECT_EQ(FindChannel(channel.name), &channel);  // unique
    EXPECT_GT(channel.queue_capacity, 0);
    // LCM takes a channel name for a regular expression.
    EXPECT_EQ(channel.name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"),
              std::string_view::npos);
  }
  EXPECT_EQ(FindChannel("NO_SUCH_CHANNEL"), nullptr);
}

}  // namespace
}  // namespace gw::wire

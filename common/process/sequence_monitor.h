// Counts lost messages by the gaps in seq.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace gw::process {

class SequenceMonitor {
 public:
  // Messages lost between the previous one of this sender on this channel and this one. The first
  // message of a sender loses nothing; nor does a seq that goes back: the sender was restarted (the
  // bus of one host does not reorder).
  // sender: distinguishes senders that share a channel ("" where there is one).
  int64_t Observe(std::string_view channel, std::string_view sender, int64_t seq) {
    const auto [entry, first] = last_.try_emplace(Key(channel, sender), seq);
    const int64_t gap = first ? 0 : seq - entry->second - 1;
    entry->second = seq;
    if (gap <= 0) return 0;
    lost_[std::string(channel)] += gap;
    return gap;
  }

  const std::map<std::string, int64_t>& lost() const { return lost_; }  // by channel

 private:
  using Key = std::pair<std::string, std::string>;
  std::map<Key, int64_t> last_;
  std::map<std::string, int64_t> lost_;
};

}  // namespace gw::process

#include "tools/data/log/inspect.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/frame_detail.h"
#include "common/wire/grid.h"
#include "common/wire/wire.h"
#include "tools/data/files/format.h"
#include "tools/data/files/json.h"

namespace gw::tools {
namespace {

// Why a message of one of our channels cannot be decoded; empty when it can.
std::optional<std::string> WhyUndecodable(std::string_view type, wire::ByteSpan message) {
  const auto why = [](const auto& result) {
    return result.ok() ? std::nullopt : std::optional(result.error().message);
  };
  if (type == "camera_t") return why(wire::Decode<wire::DecodedCamera>(message));
  if (type == "imu_t") return why(wire::Decode<ImuSample>(message));
  if (type == "wheel_t") return why(wire::Decode<WheelSample>(message));
  if (type == "dr_t") return why(wire::Decode<DrState>(message));
  if (type == "frame_pose_t") return why(wire::Decode<FramePose>(message));
  if (type == "frame_detail_t") return why(wire::Decode<FrameDetail>(message));
  if (type == "pose_t") return why(wire::Decode<Pose>(message));
  if (type == "keyframe_t") return why(wire::Decode<Keyframe>(message));
  if (type == "map_update_t") return why(wire::Decode<MapUpdate>(message));
  if (type == "map_request_t") return why(wire::Decode<MapRequest>(message));
  if (type == "place_query_t") return why(wire::Decode<PlaceQuery>(message));
  if (type == "place_match_t") return why(wire::Decode<PlaceMatch>(message));
  if (type == "grid_t") return why(wire::Decode<GridUpdate>(message));
  if (type == "obstacles_t") return why(wire::Decode<ObstacleView>(message));
  if (type == "ack_t") return why(wire::Decode<wire::Ack>(message));
  if (type == "health_t") return why(wire::Decode<Health>(message));
  if (type == "base_command_t") return why(wire::Decode<BaseCommand>(message));
  if (type == "ground_truth_t") return why(wire::Decode<GroundTruth>(message));
  if (type == "note_t") return why(wire::Decode<wire::Note>(message));
  return "no decoder for type " + std::string(type);
}

// Estimators refuse a repeated time on these; elsewhere it is legal.
bool TimesMustDiffer(std::string_view channel) {
  return channel == wire::kCamera || channel == wire::kImu || channel == wire::kWheel ||
         channel == wire::kDr || channel == wire::kGroundTruth;
}

class Inspector {
 public:
  explicit Inspector(InspectDepth depth) : depth_(depth) {}

  void Add(const process::LogEvent& event) {
    const std::string channel(event.channel);
    if (report_.events == 0) report_.begin = event.received;
    clock_.Add(event.received);
    index_ = report_.events;
    if (report_.events > 0 && event.received < previous_) {
      ++report_.receive_time_faults;
      Problem(channel, "receive time", index_, "received before the event in front of it");
    }
    previous_ = event.received;
    report_.end = std::max(report_.end, event.received);
    if (report_.events++ == 0) report_.end = event.received;

    ChannelReport& stats = report_.channels[channel];
    stats.bytes += static_cast<int64_t>(event.data.size());
    const wire::Channel* const known = wire::FindChannel(channel);
    stats.known = known != nullptr;
    if (known == nullptr) return CountTime(stats, event.received);

    const std::optional<wire::Header> header = wire::ReadHeader(event.data);
    const bool right_type = header && header->fingerprint == wire::FingerprintOf(known->type);
    std::optional<std::string> refused;
    if (!right_type) {
      refused = "is no " + std::string(known->type) + " (other fingerprint)";
    } else if (depth_ == InspectDepth::kDecode) {
      refused = WhyUndecodable(known->type, event.data);
    }
    if (refused) {
      ++stats.undecodable;
      Problem(channel, "undecodable", index_, *refused);
    }
    if (!right_type) return CountTime(stats, event.received);
    if (channel == wire::kNote) KeepNote(event);
    const std::optional<wire::Delivery> delivery = wire::ReadDelivery(event.data);
    if (delivery) {
      delivered_[{channel, delivery->session}].push_back(delivery->seq);
    } else {
      CheckOrder(channel, *header, event, stats);
    }
    CountTime(stats, header->utime);
  }

  LogReport Finish(const process::EventLogReader& reader) && {
    // Reliable messages may come twice and late; lost is what never came within a session.
    for (auto& [stream, seqs] : delivered_) {
      std::sort(seqs.begin(), seqs.end());
      seqs.erase(std::unique(seqs.begin(), seqs.end()), seqs.end());
      const int64_t lost = seqs.back() - seqs.front() + 1 - static_cast<int64_t>(seqs.size());
      if (lost == 0) continue;
      report_.channels[stream.first].lost += lost;
      report_.problems.push_back(Format("%s: %lld messages of one session never came",
                                        stream.first.c_str(), static_cast<long long>(lost)));
    }
    report_.length = clock_.length();
    report_.time_steps = clock_.steps();
    for (const TimeStep& step : report_.time_steps) report_.problems.push_back(Describe(step));
    report_.file_bytes = reader.size();
    report_.skipped_bytes = reader.skipped_bytes();
    report_.truncated = reader.truncated();
    if (report_.skipped_bytes > 0) {
      report_.problems.push_back(Format("%lld bytes are no events and were skipped",
                                        static_cast<long long>(report_.skipped_bytes)));
    }
    if (report_.truncated) {
      report_.problems.emplace_back(
          "the file ends inside an event: it was cut off (crash of the logger, full disk)");
    }
    for (const auto& [key, count] : problem_counts_) {
      if (count <= kMaxProblemsPerKind) continue;
      report_.problems.push_back(Format("%s: %s: %lld more", std::get<0>(key).c_str(),
                                        std::get<1>(key).c_str(),
                                        static_cast<long long>(count - kMaxProblemsPerKind)));
    }
    report_.ok = report_.problems.empty();
    return std::move(report_);
  }

 private:
  struct Last {
    Utime utime;
    int64_t seq = 0;
  };

  void Problem(const std::string& channel, const char* kind, int64_t event,
               const std::string& what) {
    if (++problem_counts_[{channel, kind}] > kMaxProblemsPerKind) return;
    report_.problems.push_back(channel + ": event " + std::to_string(event) + ": " + what);
  }

  static void CountTime(ChannelReport& stats, Utime utime) {
    if (stats.messages++ == 0) {
      stats.first = stats.last = utime;
      return;
    }
    const DurationUs gap = utime - stats.last;
    if (gap > stats.largest_gap) {
      stats.largest_gap = gap;
      stats.largest_gap_begin = stats.last;
    }
    stats.last = std::max(stats.last, utime);
  }

  void KeepNote(const process::LogEvent& event) {
    const Result<wire::Note> note = wire::Decode<wire::Note>(event.data);
    if (note) report_.notes.push_back({note->utime, note->key, note->text});
  }

  void CheckOrder(const std::string& channel, const wire::Header& header,
                  const process::LogEvent& event, ChannelReport& stats) {
    // HEALTH has one sequence for each process.
    std::string sender;
    if (channel == wire::kHealth) {
      const Result<Health> health = wire::Decode<Health>(event.data);
      if (health) sender = health->process;
    }
    const auto [entry, is_first] = last_.try_emplace({channel, sender});
    Last& last = entry->second;
    const Last before = std::exchange(last, {header.utime, header.seq});
    if (is_first) return;
    if (header.seq == 1 && before.seq != 1) {
      ++stats.restarts;
    } else if (header.seq <= before.seq) {
      ++stats.sequence_faults;
      Problem(channel, "sequence", index_,
              "seq " + std::to_string(header.seq) + " after " + std::to_string(before.seq));
    } else if (header.seq > before.seq + 1) {
      const int64_t lost = header.seq - before.seq - 1;
      stats.lost += lost;
      Problem(channel, "lost", index_,
              std::to_string(lost) + " messages lost between seq " + std::to_string(before.seq) +
                  " and " + std::to_string(header.seq));
    }
    const bool repeated = header.utime == before.utime && TimesMustDiffer(channel);
    if (header.utime < before.utime || repeated) {
      ++stats.time_faults;
      Problem(channel, "time", index_,
              repeated ? "repeats the utime of the message before"
                       : "utime is " + std::to_string((before.utime - header.utime).us) +
                             " us before that of the message before");
    }
  }

  InspectDepth depth_;
  LogReport report_;
  LogClock clock_;
  int64_t index_ = 0;  // of the event in the file; its own number begins anew in a joined log
  Utime previous_;     // receive time of the event before
  std::map<std::pair<std::string, std::string>, Last> last_;  // by channel and sender
  std::map<std::pair<std::string, int64_t>, std::vector<int64_t>> delivered_;  // channel, session
  std::map<std::pair<std::string, std::string>, int64_t> problem_counts_;      // channel, kind
};

long long Long(int64_t value) {
  return static_cast<long long>(value);
}

}  // namespace

Result<LogReport> InspectLog(const std::string& file, InspectDepth depth) {
  Result<process::EventLogReader> reader = process::EventLogReader::Open(file);
  if (!reader) return reader.error();
  Inspector inspector(depth);
  int64_t events = 0;
  while (const std::optional<process::LogEvent> event = reader->Next()) {
    inspector.Add(*event);
    ++events;
  }
  if (reader->error()) return *reader->error();
  if (events == 0) {
    return Error{ErrorCode::kBadData, file + ": holds no event; is it an LCM log?"};
  }
  return std::move(inspector).Finish(*reader);
}

std::string ReportText(const LogReport& report) {
  std::string out = Format("%.1f MB, %.3f s, %lld events, from %.6f\n",
                           static_cast<double>(report.file_bytes) * 1e-6, report.length.seconds(),
                           Long(report.events), report.begin.seconds());
  for (const TimeStep& step : report.time_steps) out += Describe(step) + "\n";
  out += Format("%-16s %9s %9s %11s %9s %6s\n", "channel", "messages", "rate Hz", "max gap s", "MB",
                "lost");
  for (const auto& [name, c] : report.channels) {
    out += Format("%-16s %9lld %9.2f %11.3f %9.2f %6lld%s\n", name.c_str(), Long(c.messages),
                  c.rate_hz(), c.largest_gap.seconds(), static_cast<double>(c.bytes) * 1e-6,
                  Long(c.lost), c.known ? "" : "  (not a channel of ours)");
  }
  for (const LogNote& note : report.notes) {
    out += Format("note %9.3f s  ", (note.utime - report.begin).seconds()) + note.key + ": " +
           note.text + "\n";
  }
  for (const std::string& problem : report.problems) out += "problem: " + problem + "\n";
  return out;
}

std::string ReportJson(const LogReport& report) {
  Json channels = Json::object();
  for (const auto& [name, c] : report.channels) {
    channels[name] = {{"messages", c.messages},
                      {"bytes", c.bytes},
                      {"known", c.known},
                      {"first_us", c.first.us},
                      {"last_us", c.last.us},
                      {"rate_hz", c.rate_hz()},
                      {"largest_gap_s", c.largest_gap.seconds()},
                      {"lost", c.lost},
                      {"restarts", c.restarts},
                      {"sequence_faults", c.sequence_faults},
                      {"time_faults", c.time_faults},
                      {"undecodable", c.undecodable}};
  }
  Json steps = Json::array();
  for (const TimeStep& step : report.time_steps) {
    steps.push_back({{"event", step.index}, {"from_us", step.from.us}, {"to_us", step.to.us}});
  }
  Json notes = Json::array();
  for (const LogNote& note : report.notes) {
    notes.push_back({{"utime", note.utime.us}, {"key", note.key}, {"text", note.text}});
  }
  return JsonLine({{"ok", report.ok},
                   {"bytes", report.file_bytes},
                   {"events", report.events},
                   {"begin_us", report.begin.us},
                   {"duration_s", report.length.seconds()},
                   {"skipped_bytes", report.skipped_bytes},
                   {"truncated", report.truncated},
                   {"receive_time_faults", report.receive_time_faults},
                   {"channels", channels},
                   {"time_steps", steps},
                   {"notes", notes},
                   {"problems", report.problems}});
}

}  // namespace gw::tools

#include "tools/data/foxglove/mcap_export.h"

#include <algorithm>
#include <array>
#include <map>

#include "common/process/event_log.h"
#include "tools/data/foxglove/mcap_writer.h"

namespace gw::foxglove {
namespace {

constexpr DurationUs kTickInterval = Milliseconds(100);

std::array<uint16_t, kNumTopics> AddTopics(McapWriter& writer) {
  std::map<std::string_view, uint16_t> schemas;
  std::array<uint16_t, kNumTopics> channels{};
  for (size_t i = 0; i < kNumTopics; ++i) {
    const auto [schema, added] = schemas.try_emplace(kTopics[i].schema_name, uint16_t{0});
    if (added) {
      schema->second = writer.AddSchema(schema->first, "jsonschema", SchemaText(schema->first));
    }
    channels[i] = writer.AddChannel(schema->second, kTopics[i].name, "json");
  }
  return channels;
}

class Exporter {
 public:
  Exporter(McapWriter& writer, const TranslatorOptions& options)
      : writer_(writer), channels_(AddTopics(writer)), translator_(options) {}

  Result<Done> Take(const process::LogEvent& event) {
    translator_.Take(event.channel, event.data, event.received);
    if (!started_) {
      started_ = true;
      for (const Topic topic : {Topic::kFloor, Topic::kCalibration}) {
        if (auto written = Write(translator_.State(topic)); !written) return written;
      }
    }
    if (tick_.Pass(event.received)) translator_.Tick(event.received);
    return Write(translator_.Drain());
  }

  int64_t undecodable() const {
    int64_t sum = 0;
    for (const auto& [name, count] : translator_.channels()) sum += count.undecodable;
    return sum;
  }

 private:
  Result<Done> Write(const std::vector<Message>& messages) {
    for (const Message& message : messages) {
      const auto ns = static_cast<uint64_t>(std::max<int64_t>(message.received.us, 0)) * 1000;
      auto written =
          writer_.Write(channels_[static_cast<size_t>(message.topic)], ns, *message.json);
      if (!written) return written;
    }
    return Done{};
  }

  McapWriter& writer_;
  std::array<uint16_t, kNumTopics> channels_;
  Translator translator_;
  RateLimit tick_{kTickInterval};
  bool started_ = false;
};

}  // namespace

Result<McapSummary> ExportMcap(const std::string& log, const TranslatorOptions& options,
                               const std::string& out) {
  auto reader = process::EventLogReader::Open(log);
  if (!reader) return reader.error();
  auto writer = McapWriter::Create(out);
  if (!writer) return writer.error();
  Exporter exporter(*writer, options);
  while (const auto event = reader->Next()) {
    if (auto taken = exporter.Take(*event); !taken) return taken.error();
  }
  if (reader->error()) return *reader->error();
  if (auto closed = writer->Close(); !closed) return closed.error();
  return McapSummary{writer->messages(), writer->bytes(), exporter.undecodable()};
}

}  // namespace gw::foxglove

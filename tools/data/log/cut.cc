#include "tools/data/log/cut.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "tools/data/log/log_clock.h"
#include "tools/data/log/safe_log_writer.h"

namespace gw::tools {
namespace {

std::string DescribeSpan(const Span& span) {
  std::string out = fmt::format("cut from second {:.6f}", span.begin.seconds());
  if (span.end != Span().end) out += fmt::format(" to {:.6f}", span.end.seconds());
  return out + " of the log before";
}

}  // namespace

Result<CutSummary> CutLog(const std::string& from, const Span& span, const std::string& to) {
  std::error_code ignored;
  if (std::filesystem::equivalent(from, to, ignored)) {
    return Error{ErrorCode::kInvalidArgument, to + ": is the log that is cut; choose another name"};
  }
  Result<process::EventLogReader> reader = process::EventLogReader::Open(from);
  if (!reader) return reader.error();
  Result<SafeLogWriter> writer = SafeLogWriter::Create(to);
  if (!writer) return writer.error();

  CutSummary summary;
  LogClock clock;
  bool in_span = false;
  int64_t note_seq = 0;
  std::vector<wire::Note> notes_before;
  const auto append_note = [&](wire::Note note) {
    note.seq = ++note_seq;
    ++summary.events;
    return writer->Append(note.utime, wire::kNote, wire::Encode(note));
  };
  while (const std::optional<process::LogEvent> event = reader->Next()) {
    const bool inside = span.Contains(clock.Add(event->received));
    const Result<wire::Note> note = event->channel == wire::kNote
                                        ? wire::Decode<wire::Note>(event->data)
                                        : Result<wire::Note>(Error{});
    if (note && !in_span) notes_before.push_back(*note);
    if (!inside) continue;
    if (!in_span) {
      in_span = true;
      notes_before.push_back({event->received, 0, "edit.cut", DescribeSpan(span)});
      for (wire::Note& kept : notes_before) {
        kept.utime = event->received;
        const Result<Done> written = append_note(kept);
        if (!written) return written.error();
      }
      if (note) continue;
    }
    if (!note) ++summary.events;
    const Result<Done> written =
        note ? append_note(*note) : writer->Append(event->received, event->channel, event->data);
    if (!written) return written.error();
  }
  if (reader->error()) return *reader->error();
  if (!in_span) {
    return Error{ErrorCode::kBadData, from + ": holds no event in the span; see gw-log info"};
  }
  summary.source_truncated = reader->truncated();
  summary.source_skipped_bytes = reader->skipped_bytes();
  summary.bytes = writer->bytes_written();
  const Result<Done> committed = writer->Commit();
  if (!committed) return committed.error();
  return summary;
}

}  // namespace gw::tools

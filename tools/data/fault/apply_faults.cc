#include "tools/data/fault/apply_faults.h"

#include <filesystem>
#include <optional>

#include "tools/data/log/safe_log_writer.h"

namespace gw::fault {

Result<FaultSummary> ApplyFaults(const std::string& from, const FaultPlan& plan,
                                 const std::string& to, const Progress& progress) {
  std::error_code ignored;
  if (std::filesystem::equivalent(from, to, ignored)) {
    return Error{ErrorCode::kInvalidArgument, to + ": is the input; choose another name"};
  }
  Result<process::EventLogReader> reader = process::EventLogReader::Open(from);
  if (!reader) return reader.error();
  Result<tools::SafeLogWriter> writer = tools::SafeLogWriter::Create(to);
  if (!writer) return writer.error();
  FaultInjector injector(plan,
                         [&](Utime received, std::string_view channel, const wire::Bytes& message) {
                           return writer->Append(received, channel, message);
                         });
  bool any = false;
  while (const std::optional<process::LogEvent> event = reader->Next()) {
    any = true;
    const Result<Done> added = injector.Add(*event);
    if (!added) return added.error();
    progress(reader->position(), reader->size());
  }
  if (reader->error()) return *reader->error();
  if (!any) return Error{ErrorCode::kBadData, from + ": holds no event; is it an LCM log?"};
  auto summary = injector.Finish();
  if (!summary) return summary;
  summary->bytes = writer->bytes_written();
  const Result<Done> committed = writer->Commit();
  if (!committed) return committed.error();
  return summary;
}

}  // namespace gw::fault

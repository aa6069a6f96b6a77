#include "tools/data/log/safe_log_writer.h"

#include <filesystem>

namespace gw::tools {

Result<SafeLogWriter> SafeLogWriter::Create(const std::string& file) {
  Result<process::EventLogWriter> writer = process::EventLogWriter::Create(file + ".partial");
  if (!writer) return writer.error();
  return SafeLogWriter(file, *std::move(writer));
}

SafeLogWriter::~SafeLogWriter() {
  if (writer_ == nullptr) return;
  writer_.reset();
  std::error_code ignored;
  std::filesystem::remove(partial(), ignored);
}

Result<Done> SafeLogWriter::Commit() {
  const Result<Done> closed = writer_->Close();
  if (!closed) return closed.error();
  std::error_code error;
  std::filesystem::rename(partial(), file_, error);
  if (error) {
    return Error{ErrorCode::kIo, file_ + ": cannot be put in place: " + error.message()};
  }
  writer_.reset();
  return Done{};
}

}  // namespace gw::tools

// Tables of text as the data sets use them: one record a line, fields separated by blanks or
// commas, '#' starts a comment line. Between two commas may be nothing: an empty field. A first
// line of words alone, before one that begins with a number, is a heading. Files from Windows are
// read as they are: byte-order mark, CRLF. A field in double quotes may hold blanks and commas.
// Every error names file and line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::importer {

class TextRow {
 public:
  TextRow(const std::filesystem::path& file, int line, std::vector<std::string> fields,
          std::string after_first)
      : file_(&file),
        line_(line),
        fields_(std::move(fields)),
        after_first_(std::move(after_first)) {}

  size_t size() const { return fields_.size(); }
  int line() const { return line_; }
  // Precondition: index < size().
  const std::string& text(size_t index) const { return fields_[index]; }

  // What stands behind the first field, as it is written, without blanks around it: a file name
  // that may hold blanks and commas.
  const std::string& after_first() const { return after_first_; }
  // True when one of count fields from index on says nan, inf, null, none, NA or nothing: how
  // programs write a measurement that they do not have. False where fields are missing.
  bool HasNoValue(size_t index, size_t count) const;

  // "FILE:LINE".
  std::string place() const { return file_->string() + ":" + std::to_string(line_); }
  // "FILE:LINE: what".
  Error BadData(const std::string& what) const;

  // A finite number, a time in seconds or in nanoseconds; error when missing or malformed.
  Result<double> Number(size_t index) const;
  Result<Utime> Seconds(size_t index) const;
  Result<int64_t> Nanoseconds(size_t index) const;
  // count finite numbers from index on.
  Result<std::vector<double>> Numbers(size_t index, size_t count) const;
  // tx ty tz qx qy qz qw from index on. Error when the quaternion's norm is off by more than 5 %.
  Result<SE3> PoseXyzQxyzw(size_t index) const;

 private:
  const std::filesystem::path* file_;  // owned by the table
  int line_;
  std::vector<std::string> fields_;
  std::string after_first_;
};

// The rows of a sensor's file that hold no measurement (nan, null, or what Add says): counted and
// left out, so that a few of them do not make a recording useless.
class SpoiltRows {
 public:
  // True when the row has no value in one of the fields; counts it.
  bool Skip(const TextRow& row, size_t index, size_t count);
  void Add(const TextRow& row, const std::string& why);

  // Warns, with the first of them. Error kBadData when they are more than half of `rows`: then the
  // file does not hold what it should.
  Result<Done> Report(size_t rows, std::vector<std::string>& warnings) const;

 private:
  size_t count_ = 0;
  std::string first_;  // "FILE:LINE: why"
};

class TextTable {
 public:
  // what: the file's role, for the message when it is missing. Error: kNotFound, kIo, or kBadData
  // when it holds no record.
  static Result<TextTable> Read(const std::filesystem::path& file, const std::string& what);

  const std::filesystem::path& file() const { return *file_; }
  const std::vector<TextRow>& rows() const { return rows_; }

  // Calls `read` for each row. The error holds what it refused, of more than kMostFaults rows the
  // others counted. A last line that `read` refuses and that has no newline is one that was being
  // written when the recording ended: it is left out, with a warning.
  Result<Done> ForEach(std::vector<std::string>& warnings,
                       const std::function<Result<Done>(const TextRow&)>& read) const;

  static constexpr size_t kMostFaults = 5;

 private:
  std::unique_ptr<std::filesystem::path> file_;  // stable address for the rows
  std::vector<TextRow> rows_;
  bool cut_off_ = false;  // the last row has no newline
};

// Rounds to the nearest microsecond.
constexpr Utime UtimeFromNanoseconds(int64_t ns) {
  return {ns >= 0 ? (ns + 500) / 1000 : (ns - 500) / 1000};
}

}  // namespace gw::importer

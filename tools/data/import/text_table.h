// Tables of text as the data sets use them: one record a line, fields separated by blanks or
// commas, '#' starts a comment line. Files from Windows are read as they are: byte-order mark,
// CRLF. A field in double quotes may hold blanks and commas. Every error names file and line.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/core/se3.h"
#include "common/core/time.h"

namespace gw::importer {

class TextRow {
 public:
  TextRow(const std::filesystem::path& file, int line, std::vector<std::string> fields)
      : file_(&file), line_(line), fields_(std::move(fields)) {}

  size_t size() const { return fields_.size(); }
  int line() const { return line_; }
  // Precondition: index < size().
  const std::string& text(size_t index) const { return fields_[index]; }

  // The fields from `index` on with single blanks between: a file name that holds blanks.
  // Precondition: index < size().
  std::string RestOfLine(size_t index) const;
  // True when one of count fields from index on says nan or inf: how programs write a measurement
  // that they do not have. False where fields are missing.
  bool HasNonFinite(size_t index, size_t count) const;

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
};

// The rows of a sensor's file that hold no measurement (nan, or what Add says): counted and left
// out, so that a few of them do not make a recording useless.
class SpoiltRows {
 public:
  // True when the row has nan or inf in the fields; counts it.
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

 private:
  std::unique_ptr<std::filesystem::path> file_;  // stable address for the rows
  std::vector<TextRow> rows_;
};

// Rounds to the nearest microsecond.
constexpr Utime UtimeFromNanoseconds(int64_t ns) {
  return {ns >= 0 ? (ns + 500) / 1000 : (ns - 500) / 1000};
}

}  // namespace gw::importer

#include "tools/data/import/text_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include "tools/data/files/faults.h"

namespace gw::importer {
namespace {

constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";

constexpr const char* kBlanks = " \t\r";
constexpr const char* kSeparators = " \t\r,";

struct SplitLine {
  std::vector<std::string> fields;
  size_t after_first = std::string::npos;  // where the second field begins
};

SplitLine Split(const std::string& line) {
  SplitLine out;
  bool after_comma = true;  // or at the begin of the line
  for (size_t at = line.find_first_not_of(kBlanks); at < line.size();
       at = line.find_first_not_of(kBlanks, at)) {
    if (line[at] == ',') {
      if (after_comma) out.fields.emplace_back();
      after_comma = true;
      ++at;
      continue;
    }
    if (out.fields.size() == 1) out.after_first = at;
    const size_t closing = line[at] == '"' ? line.find('"', at + 1) : std::string::npos;
    const size_t end = closing != std::string::npos
                           ? closing
                           : std::min(line.find_first_of(kSeparators, at), line.size());
    const size_t begin = closing != std::string::npos ? at + 1 : at;
    out.fields.push_back(line.substr(begin, end - begin));
    at = closing != std::string::npos ? closing + 1 : end;
    after_comma = false;
  }
  return out;
}

// The rest of a line as one name: without blanks at its end and without quotes around all of it.
std::string NameIn(const std::string& line, size_t begin) {
  if (begin == std::string::npos) return "";
  std::string name = line.substr(begin, line.find_last_not_of(kBlanks) + 1 - begin);
  const bool quoted =
      name.size() > 1 && name.front() == '"' && name.find('"', 1) == name.size() - 1;
  return quoted ? name.substr(1, name.size() - 2) : name;
}

bool IsEmpty(const std::string& field) {
  return field.empty();
}

// A finite number, or how programs write one that is not.
std::optional<double> AnyNumber(const std::string& field) {
  double value = 0;
  const char* const begin = field.data() + (field.starts_with('+') ? 1 : 0);
  const auto [end, status] = std::from_chars(begin, field.data() + field.size(), value);
  if (status != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

bool MeansNoValue(std::string field) {
  const std::optional<double> number = AnyNumber(field);
  if (number) return !std::isfinite(*number);
  std::transform(field.begin(), field.end(), field.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return field.empty() || field == "null" || field == "none" || field == "na" || field == "n/a";
}

// Names of columns without a '#': words, before a line that begins with a number.
bool IsHeading(const TextRow& row, const TextRow& next) {
  for (size_t i = 0; i < row.size(); ++i) {
    if (AnyNumber(row.text(i))) return false;
  }
  return AnyNumber(next.text(0)).has_value();
}

}  // namespace

Error TextRow::BadData(const std::string& what) const {
  return {ErrorCode::kBadData, place() + ": " + what};
}

bool TextRow::HasNoValue(size_t index, size_t count) const {
  const size_t end = std::min(index + count, fields_.size());
  for (size_t i = index; i < end; ++i) {
    if (MeansNoValue(fields_[i])) return true;
  }
  return false;
}

bool SpoiltRows::Skip(const TextRow& row, size_t index, size_t count) {
  if (!row.HasNoValue(index, count)) return false;
  Add(row, "holds nan, null or an empty field");
  return true;
}

void SpoiltRows::Add(const TextRow& row, const std::string& why) {
  if (count_++ == 0) first_ = row.place() + ": " + why;
}

Result<Done> SpoiltRows::Report(size_t rows, std::vector<std::string>& warnings) const {
  if (count_ == 0) return Done{};
  const std::string text = first_ + "; " + std::to_string(count_) + " of " + std::to_string(rows) +
                           " rows are of no use";
  if (2 * count_ > rows) return Error{ErrorCode::kBadData, text};
  warnings.push_back(text + " and were left out");
  return Done{};
}

Result<double> TextRow::Number(size_t index) const {
  if (index >= fields_.size()) {
    return BadData("has " + std::to_string(fields_.size()) + " fields, at least " +
                   std::to_string(index + 1) + " are needed; is the file cut off here?");
  }
  const std::optional<double> value = AnyNumber(fields_[index]);
  if (!value || !std::isfinite(*value)) {
    return BadData("'" + fields_[index] + "' is not a finite number; correct or remove the line");
  }
  return *value;
}

Result<Utime> TextRow::Seconds(size_t index) const {
  const Result<double> seconds = Number(index);
  if (!seconds) return seconds.error();
  if (std::abs(*seconds) > 1e11) {
    return BadData("'" + fields_[index] + "' is no time in seconds; is it in nanoseconds?");
  }
  return UtimeFromSeconds(*seconds);
}

Result<int64_t> TextRow::Nanoseconds(size_t index) const {
  if (index >= fields_.size()) return BadData("the time is missing; is the file cut off here?");
  const std::string& field = fields_[index];
  int64_t value = 0;
  const auto [end, status] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (status != std::errc() || end != field.data() + field.size()) {
    return BadData("'" + field + "' is no whole number of nanoseconds; correct or remove the line");
  }
  return value;
}

Result<std::vector<double>> TextRow::Numbers(size_t index, size_t count) const {
  std::vector<double> values;
  for (size_t i = index; i < index + count; ++i) {
    const Result<double> value = Number(i);
    if (!value) return value.error();
    values.push_back(*value);
  }
  return values;
}

Result<SE3> TextRow::PoseXyzQxyzw(size_t index) const {
  const Result<std::vector<double>> v = Numbers(index, 7);
  if (!v) return v.error();
  const Eigen::Quaterniond q((*v)[6], (*v)[3], (*v)[4], (*v)[5]);
  if (std::abs(q.norm() - 1) > 0.05) {
    return BadData("the quaternion has norm " + std::to_string(q.norm()) +
                   ", expected 1 (order qx qy qz qw); correct or remove the line");
  }
  return SE3(q, {(*v)[0], (*v)[1], (*v)[2]});
}

Result<TextTable> TextTable::Read(const std::filesystem::path& file, const std::string& what) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound, file.string() + ": not there; it should hold " + what +
                                           "; check the source folder and the format"};
  }
  std::ifstream stream(file);
  if (!stream) {
    return Error{ErrorCode::kIo, file.string() + ": cannot be read; check its permissions"};
  }
  TextTable table;
  table.file_ = std::make_unique<std::filesystem::path>(file);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    table.cut_off_ = stream.eof();
    if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, 3);
    SplitLine split = Split(line);
    // Spreadsheets write empty lines as commas.
    if (std::all_of(split.fields.begin(), split.fields.end(), IsEmpty)) continue;
    if (split.fields.front().starts_with('#')) continue;
    table.rows_.emplace_back(*table.file_, number, std::move(split.fields),
                             NameIn(line, split.after_first));
  }
  if (table.rows_.size() > 1 && IsHeading(table.rows_[0], table.rows_[1])) {
    table.rows_.erase(table.rows_.begin());
  }
  if (stream.bad()) return Error{ErrorCode::kIo, file.string() + ": reading failed"};
  if (table.rows_.empty()) {
    return Error{ErrorCode::kBadData, file.string() + ": holds no record; it should hold " + what};
  }
  return table;
}

Result<Done> TextTable::ForEach(std::vector<std::string>& warnings,
                                const std::function<Result<Done>(const TextRow&)>& read) const {
  tools::Faults faults;
  size_t refused = 0;
  for (const TextRow& row : rows_) {
    const Result<Done> done = read(row);
    if (done) continue;
    if (cut_off_ && &row == &rows_.back() && rows_.size() > 1) {
      warnings.push_back(done.error().message + "; the last line is cut off and was left out");
      continue;
    }
    if (++refused <= kMostFaults) faults.Add(done.error());
  }
  if (refused > kMostFaults) {
    faults.Add({ErrorCode::kBadData, file_->string() + ": " +
                                         std::to_string(refused - kMostFaults) +
                                         " more lines like these"});
  }
  return faults.Verdict();
}

}  // namespace gw::importer

#include "tools/data/import/text_table.h"

#include <charconv>
#include <cmath>
#include <fstream>

namespace gw::importer {
namespace {

constexpr const char* kByteOrderMark = "\xEF\xBB\xBF";

std::vector<std::string> SplitFields(const std::string& line) {
  constexpr const char* kSeparators = " \t,\r";
  std::vector<std::string> fields;
  size_t begin = line.find_first_not_of(kSeparators);
  while (begin != std::string::npos) {
    const size_t closing = line[begin] == '"' ? line.find('"', begin + 1) : std::string::npos;
    if (closing != std::string::npos) {
      fields.push_back(line.substr(begin + 1, closing - begin - 1));
      begin = line.find_first_not_of(kSeparators, closing + 1);
      continue;
    }
    const size_t end = line.find_first_of(kSeparators, begin);
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return fields;
}

}  // namespace

Error TextRow::BadData(const std::string& what) const {
  return {ErrorCode::kBadData, place() + ": " + what};
}

std::string TextRow::RestOfLine(size_t index) const {
  std::string rest = fields_[index];
  for (size_t i = index + 1; i < fields_.size(); ++i) rest += " " + fields_[i];
  return rest;
}

bool TextRow::HasNonFinite(size_t index, size_t count) const {
  for (size_t i = index; i < index + count && i < fields_.size(); ++i) {
    double value = 0;
    const std::string& field = fields_[i];
    const char* const begin = field.data() + (field.starts_with('+') ? 1 : 0);
    const auto [end, status] = std::from_chars(begin, field.data() + field.size(), value);
    if (status == std::errc() && end == field.data() + field.size() && !std::isfinite(value)) {
      return true;
    }
  }
  return false;
}

bool SpoiltRows::Skip(const TextRow& row, size_t index, size_t count) {
  if (!row.HasNonFinite(index, count)) return false;
  Add(row, "holds nan or inf");
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
  const std::string& field = fields_[index];
  double value = 0;
  const char* begin = field.data() + (field.front() == '+' ? 1 : 0);
  const auto [end, status] = std::from_chars(begin, field.data() + field.size(), value);
  if (status != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) {
    return BadData("'" + field + "' is not a finite number; correct or remove the line");
  }
  return value;
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
    if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, 3);
    std::vector<std::string> fields = SplitFields(line);
    if (fields.empty() || fields.front().front() == '#') continue;
    table.rows_.emplace_back(*table.file_, number, std::move(fields));
  }
  if (stream.bad()) return Error{ErrorCode::kIo, file.string() + ": reading failed"};
  if (table.rows_.empty()) {
    return Error{ErrorCode::kBadData, file.string() + ": holds no record; it should hold " + what};
  }
  return table;
}

}  // namespace gw::importer

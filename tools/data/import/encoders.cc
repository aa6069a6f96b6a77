#include "tools/data/import/encoders.h"

#include <cmath>

#include "tools/data/import/streams.h"
#include "tools/data/import/text_table.h"

namespace gw::importer {
namespace {

struct Reading {
  Utime utime;
  double left = 0, right = 0;  // ticks
};

uint16_t Wrapped(double ticks) {
  return static_cast<uint16_t>(static_cast<uint64_t>(std::llround(ticks)));
}

WheelSample Between(const Reading& a, const Reading& b, const EncoderBase& base) {
  WheelSample sample;
  sample.utime_begin = a.utime;
  sample.utime = b.utime;
  sample.has_ticks = true;
  sample.left_ticks = Wrapped(b.left);
  sample.right_ticks = Wrapped(b.right);
  SetArc((b.left - a.left) / base.ticks_per_metre, (b.right - a.right) / base.ticks_per_metre,
         base.track_m, sample);
  return sample;
}

}  // namespace

void SetArc(double left_m, double right_m, double track_m, WheelSample& sample) {
  const double way = (left_m + right_m) / 2;
  sample.dyaw_rad = (right_m - left_m) / track_m;
  // Chord of the arc; the direction is half the turn.
  const double half = sample.dyaw_rad / 2;
  const double chord = std::abs(half) > 1e-9 ? way * std::sin(half) / half : way;
  sample.dx_m = chord * std::cos(half);
  sample.dy_m = chord * std::sin(half);
}

Result<std::vector<WheelSample>> ReadEncoders(const std::filesystem::path& file,
                                              const EncoderBase& base,
                                              std::vector<std::string>& warnings) {
  const Result<TextTable> table = TextTable::Read(file, "lines `t left_ticks right_ticks`");
  if (!table) return table.error();
  std::vector<Reading> readings;
  SpoiltRows spoilt;
  const auto read = table->ForEach(warnings, [&](const TextRow& row) -> Result<Done> {
    if (spoilt.Skip(row, 0, 3)) return Done{};
    const Result<Utime> utime = row.Seconds(0);
    if (!utime) return utime.error();
    const Result<std::vector<double>> ticks = row.Numbers(1, 2);
    if (!ticks) return ticks.error();
    readings.push_back({*utime, (*ticks)[0], (*ticks)[1]});
    return Done{};
  });
  if (!read) return read.error();
  Result<Done> good = spoilt.Report(table->rows().size(), warnings);
  if (good) good = MakeOrdered(readings, file.filename().string(), warnings);
  if (!good) return good.error();
  if (readings.size() < 2) {
    return Error{ErrorCode::kBadData,
                 file.string() + ": holds a single reading; increments need at least two"};
  }
  std::vector<WheelSample> wheels;
  for (size_t i = 1; i < readings.size(); ++i) {
    wheels.push_back(Between(readings[i - 1], readings[i], base));
  }
  return wheels;
}

}  // namespace gw::importer

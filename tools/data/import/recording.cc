#include "tools/data/import/recording.h"

#include <algorithm>

#include "tools/data/import/streams.h"

namespace gw::importer {
namespace {

template <typename Sample>
void SetRate(const std::vector<Sample>& samples, double& rate_hz) {
  std::vector<Utime> times;
  for (const Sample& sample : samples) times.push_back(sample.utime);
  const double rate = MedianRateHz(times);
  if (rate > 0) rate_hz = rate;
}

}  // namespace

std::string FolderName(const std::filesystem::path& source) {
  return std::filesystem::absolute(source / ".")
      .lexically_normal()
      .parent_path()
      .filename()
      .string();
}

void DescribeSensors(Recording& recording) {
  Calibration& calibration = recording.calibration;
  calibration.imu.present = !recording.imu.empty();
  if (calibration.imu.present) {
    calibration.imu.has_accel = std::any_of(recording.imu.begin(), recording.imu.end(),
                                            [](const ImuSample& s) { return s.has_accel; });
  }
  SetRate(recording.imu, calibration.imu.rate_hz);
  calibration.wheel.present = !recording.wheel.empty();
  SetRate(recording.wheel, calibration.wheel.rate_hz);
}

}  // namespace gw::importer

// Keeps of a run what gw-view would have shown of it, for the report.
#pragma once

#include <string>
#include <vector>

#include "common/process/bus.h"
#include "tools/data/files/json_fwd.h"
#include "tools/data/foxglove/translator.h"

namespace gw::demo {

class RunRecorder {
 public:
  explicit RunRecorder(foxglove::TranslatorOptions options);

  // The bus must live as long as the recorder.
  static Result<Done> Attach(process::Bus& bus, RunRecorder& recorder);

  // [topic, message] in the order in which they came: every image's weights, errors, log, a part of
  // the images with their features, and poses five times a second; then floor map, way, map and
  // health as they are in the end.
  std::vector<tools::Json> Messages();

  static constexpr size_t kMostImages = 160;  // of about 30 kB with their features
  static constexpr DurationUs kLeastSpacing = Milliseconds(250);

 private:
  void Take(const std::string& channel, wire::ByteSpan bytes, Utime received);
  void Keep(const foxglove::Message& message);
  void ThinImages();

  foxglove::Translator translator_;
  std::vector<foxglove::Message> kept_;
  DurationUs image_spacing_ = kLeastSpacing;
  size_t num_images_ = 0;
  Utime last_image_, last_pose_;
};

}  // namespace gw::demo

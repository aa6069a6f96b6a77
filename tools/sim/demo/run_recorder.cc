#include "tools/sim/demo/run_recorder.h"

#include <set>
#include <string>
#include <utility>

#include "common/wire/channels.h"
#include "tools/data/files/json.h"

namespace gw::demo {
namespace {

using foxglove::Message;
using foxglove::Topic;
using tools::Json;

constexpr DurationUs kPoseSpacing = Milliseconds(200);

size_t Bit(Topic topic) {
  return static_cast<size_t>(topic);
}

// "sec.nsec" of a message: the time of the image that it belongs to.
std::pair<int64_t, int64_t> TimeOf(const Json& message) {
  const Json& time = message.at("timestamp");
  return {time.at("sec").get<int64_t>(), time.at("nsec").get<int64_t>()};
}

}  // namespace

RunRecorder::RunRecorder(foxglove::TranslatorOptions options) : translator_(std::move(options)) {
  foxglove::Translator::Topics wanted;
  for (const Topic topic : {Topic::kTransforms, Topic::kWeights, Topic::kError, Topic::kLog,
                            Topic::kImage, Topic::kFeatures}) {
    wanted.set(Bit(topic));
  }
  translator_.SetWanted(wanted);
}

Result<Done> RunRecorder::Attach(process::Bus& bus, RunRecorder& recorder) {
  for (const wire::Channel& channel : wire::kChannels) {
    const std::string name(channel.name);
    auto ok = bus.Subscribe(name, [&recorder, name](auto bytes, Utime received) {
      recorder.Take(name, bytes, received);
    });
    if (!ok) return ok;
  }
  return Done{};
}

void RunRecorder::Take(const std::string& channel, wire::ByteSpan bytes, Utime received) {
  // An image that is not kept is not made small either.
  if (channel == wire::kCamera && num_images_ > 0 && received - last_image_ < image_spacing_) {
    return;
  }
  translator_.Take(channel, bytes, received);
  for (const Message& message : translator_.Drain()) Keep(message);
}

void RunRecorder::Keep(const Message& message) {
  if (message.topic == Topic::kTransforms) {
    if (message.received - last_pose_ < kPoseSpacing) return;
    last_pose_ = message.received;
  }
  if (message.topic == Topic::kImage) {
    if (num_images_ == kMostImages) ThinImages();
    last_image_ = message.received;
    ++num_images_;
  }
  kept_.push_back(message);
}

// Every second image goes; from here on half as many are kept.
void RunRecorder::ThinImages() {
  size_t seen = 0;
  std::erase_if(kept_, [&seen](const Message& message) {
    return message.topic == Topic::kImage && seen++ % 2 == 1;
  });
  num_images_ = kMostImages / 2;
  image_spacing_ = image_spacing_ + image_spacing_;
}

std::vector<Json> RunRecorder::Messages() {
  std::vector<Message> messages = translator_.State(Topic::kFloor);
  messages.insert(messages.end(), kept_.begin(), kept_.end());
  for (const Topic topic :
       {Topic::kTrajectory, Topic::kKeyframes, Topic::kLandmarks, Topic::kHealth}) {
    for (Message& message : translator_.State(topic)) messages.push_back(std::move(message));
  }
  std::set<std::pair<int64_t, int64_t>> images;
  std::vector<Json> out;
  for (const Message& message : messages) {
    Json json = Json::parse(*message.json);
    if (message.topic == Topic::kImage) images.insert(TimeOf(json));
    // Features of images that went.
    if (message.topic == Topic::kFeatures && !images.contains(TimeOf(json))) continue;
    out.push_back(Json::array({std::string(foxglove::Info(message.topic).name), std::move(json)}));
  }
  return out;
}

}  // namespace gw::demo

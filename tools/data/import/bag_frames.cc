#include "tools/data/import/bag_frames.h"

#include <algorithm>
#include <utility>

#include "tools/data/files/format.h"
#include "tools/data/import/ros_images.h"
#include "tools/data/import/streams.h"

namespace gw::importer {
namespace {

class BagFrames : public FrameSource {
 public:
  BagFrames(std::unique_ptr<bag::Bag> bag, std::vector<BagPair> pairs, std::string name,
            BagImageRules rules)
      : bag_(std::move(bag)),
        pairs_(std::move(pairs)),
        name_(std::move(name)),
        rules_(std::move(rules)) {}

  size_t size() const override { return pairs_.size(); }
  Utime utime(size_t index) const override { return pairs_[index].utime; }

  Result<FramePixels> Load(size_t index) const override {
    const BagPair& pair = pairs_[index];
    FramePixels pixels;
    Result<Image> left = LoadImage(pair.left, false, rules_.left);
    if (!left) return left.error();
    pixels.left = *std::move(left);
    Result<Image> second = LoadImage(pair.second, rules_.second_is_depth,
                                     rules_.second_is_depth ? rules_.left : rules_.right);
    if (!second) return second.error();
    if (pixels.left.width != second->width || pixels.left.height != second->height) {
      return Refused(pair.second,
                     tools::Format("is %d x %d, its partner %d x %d; %s", second->width,
                                   second->height, pixels.left.width, pixels.left.height,
                                   rules_.second_is_depth ? "is the depth aligned to this camera?"
                                                          : "both eyes must have one size"));
    }
    (rules_.second_is_depth ? pixels.depth : pixels.right) = *std::move(second);
    return pixels;
  }

 private:
  Error Refused(const bag::MessageRef& message, const std::string& what) const {
    return {ErrorCode::kBadData,
            name_ + ": topic " + bag_->topics()[message.topic].name + ": " + what};
  }

  Result<Image> LoadImage(const bag::MessageRef& message, bool depth,
                          const std::optional<Undistorter>& undistorter) const {
    const Result<bag::Bytes> bytes = bag_->Read(message);
    if (!bytes) return Refused(message, bytes.error().message);
    const bag::Topic& topic = bag_->topics()[message.topic];
    const RosMessage ros{*bytes, topic.serialization};
    Result<Image> image = depth ? DecodeRosDepth(ros, topic.type, rules_.depth_unit_m)
                                : DecodeRosGrey(ros, topic.type);
    if (!image) return Refused(message, image.error().message);
    if (!undistorter) return image;
    if (!undistorter->Fits(*image)) {
      return Refused(message, "has another size than its CameraInfo states");
    }
    return undistorter->Apply(*image);
  }

  std::unique_ptr<bag::Bag> bag_;
  std::vector<BagPair> pairs_;
  std::string name_;
  BagImageRules rules_;
};

std::vector<Utime> TimesOf(const std::vector<BagImage>& images) {
  std::vector<Utime> times;
  for (const BagImage& image : images) times.push_back(image.utime);
  return times;
}

}  // namespace

std::unique_ptr<FrameSource> MakeBagFrames(std::unique_ptr<bag::Bag> bag,
                                           std::vector<BagPair> pairs, std::string name,
                                           BagImageRules rules) {
  return std::make_unique<BagFrames>(std::move(bag), std::move(pairs), std::move(name),
                                     std::move(rules));
}

Result<std::vector<BagPair>> PairImages(const std::vector<BagImage>& left,
                                        const std::vector<BagImage>& second, bool second_is_depth,
                                        std::vector<std::string>& warnings) {
  const std::vector<Utime> left_times = TimesOf(left), second_times = TimesOf(second);
  const double rate_hz = std::max(1.0, MedianRateHz(left_times));
  const DurationUs most =
      second_is_depth ? DurationUs{static_cast<int64_t>(std::min(0.02, 0.5 / rate_hz) * 1e6)}
                      : LargestEyeDifference(left_times);
  std::vector<BagPair> pairs;
  for (const auto& [i, j] : second_is_depth ? AssociateNearest(left_times, second_times, most)
                                            : PairEyes(left_times, second_times, warnings)) {
    pairs.push_back({left[i].utime, left[i].message, second[j].message});
  }
  const char* const partner = second_is_depth ? "depth image" : "right image";
  if (pairs.empty()) {
    return Error{ErrorCode::kBadData,
                 tools::Format("none of %d images has a %s within %.1f ms; are the two on one "
                               "clock, and of one camera?",
                               left.size(), partner, most.seconds() * 1e3)};
  }
  if (pairs.size() < left.size()) {
    warnings.push_back(tools::Format("%d of %d images have no %s within %.1f ms; left out",
                                     left.size() - pairs.size(), left.size(), partner,
                                     most.seconds() * 1e3));
  }
  return pairs;
}

}  // namespace gw::importer

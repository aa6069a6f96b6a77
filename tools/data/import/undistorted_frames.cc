#include "tools/data/import/undistorted_frames.h"

#include <utility>

namespace gw::importer {
namespace {

class UndistortedFrames : public FrameSource {
 public:
  UndistortedFrames(std::unique_ptr<FrameSource> source, std::optional<Undistorter> left,
                    std::optional<Undistorter> right)
      : source_(std::move(source)), left_(std::move(left)), right_(std::move(right)) {}

  size_t size() const override { return source_->size(); }
  Utime utime(size_t index) const override { return source_->utime(index); }

  Result<FramePixels> Load(size_t index) const override {
    Result<FramePixels> pixels = source_->Load(index);
    if (!pixels) return pixels;
    for (const auto& [lens, image] :
         {std::pair{&left_, &pixels->left}, {&right_, &pixels->right}}) {
      if (!lens->has_value()) continue;
      if (!(*lens)->Fits(*image)) {
        return Error{ErrorCode::kBadData, "image " + std::to_string(index) + " is " +
                                              std::to_string(image->width) + " x " +
                                              std::to_string(image->height) +
                                              ", its calibration is of another size"};
      }
      *image = (*lens)->Apply(*image);
    }
    return pixels;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::optional<Undistorter> left_, right_;
};

}  // namespace

std::unique_ptr<FrameSource> UndistortFrames(std::unique_ptr<FrameSource> source,
                                             std::optional<Undistorter> left,
                                             std::optional<Undistorter> right) {
  return std::make_unique<UndistortedFrames>(std::move(source), std::move(left), std::move(right));
}

}  // namespace gw::importer

#include "tools/data/import/image_file.h"

#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "tools/data/files/faults.h"
#include "tools/data/import/streams.h"

namespace gw::importer {
namespace {

Error BadImage(const std::filesystem::path& file, const std::string& what) {
  return {ErrorCode::kBadData, file.string() + ": " + what};
}

std::string Describe(const cv::Mat& pixels) {
  return std::to_string(pixels.elemSize1() * 8) + "-bit, " + std::to_string(pixels.channels()) +
         " channels";
}

Result<cv::Mat> Decode(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return Error{ErrorCode::kNotFound,
                 file.string() + ": not there; --skip-missing leaves such frames out"};
  }
  try {
    cv::Mat pixels = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    if (!pixels.empty()) return pixels;
  } catch (const cv::Exception&) {
    // Same answer as for an empty image.
  }
  return BadImage(file, "cannot be decoded as an image; copy the file again from the source");
}

Image WithSize(const cv::Mat& pixels, PixelFormat format) {
  Image image;
  image.width = pixels.cols;
  image.height = pixels.rows;
  image.format = format;
  image.bytes.resize(static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                     static_cast<size_t>(BytesPerPixel(format)));
  return image;
}

Image CopyPixels(const cv::Mat& pixels, PixelFormat format) {
  Image image = WithSize(pixels, format);
  const size_t row_bytes = image.bytes.size() / static_cast<size_t>(image.height);
  for (int y = 0; y < pixels.rows; ++y) {
    std::copy_n(pixels.ptr<uint8_t>(y), row_bytes,
                image.bytes.begin() + static_cast<int64_t>(row_bytes) * y);
  }
  return image;
}

class FileFrames : public FrameSource {
 public:
  FileFrames(std::vector<FrameFiles> files, int width, int height)
      : files_(std::move(files)), width_(width), height_(height) {}

  size_t size() const override { return files_.size(); }
  Utime utime(size_t index) const override { return files_[index].utime; }

  Result<FramePixels> Load(size_t index) const override {
    const FrameFiles& files = files_[index];
    FramePixels pixels;
    for (const auto& [file, image, is_depth] : {std::tuple{&files.left, &pixels.left, false},
                                                {&files.right, &pixels.right, false},
                                                {&files.depth, &pixels.depth, true}}) {
      if (file->empty()) continue;
      Result<Image> loaded = is_depth ? LoadDepthImage(*file) : LoadGreyImage(*file);
      if (!loaded) return loaded.error();
      if (loaded->width != width_ || loaded->height != height_) {
        return BadImage(*file, "is " + std::to_string(loaded->width) + " x " +
                                   std::to_string(loaded->height) + ", but the first image is " +
                                   std::to_string(width_) + " x " + std::to_string(height_) +
                                   "; all images of a recording must have one size");
      }
      *image = *std::move(loaded);
    }
    return pixels;
  }

 private:
  std::vector<FrameFiles> files_;
  int width_, height_;
};

// False when a file of the frame is not there; each such is named.
bool NameMissingFiles(const FrameFiles& frame, tools::Faults& faults) {
  bool complete = true;
  for (const std::filesystem::path* file : {&frame.left, &frame.right, &frame.depth}) {
    std::error_code ignored;
    if (file->empty() || std::filesystem::is_regular_file(*file, ignored)) continue;
    faults.Add({ErrorCode::kNotFound, frame.listed_at + ": " + file->string() + " is not there"});
    complete = false;
  }
  return complete;
}

// The first image that can be read: without skip_missing the very first, or a fault.
Image FirstImage(const std::vector<FrameFiles>& files, const ReadOptions& options,
                 tools::Faults& faults) {
  for (const FrameFiles& frame : files) {
    Result<Image> image = LoadGreyImage(frame.left);
    if (image) return *std::move(image);
    faults.Add(image.error());
    if (!options.skip_missing) break;
  }
  return {};
}

// Where files are not there, whoever restores them wants to know of those that are broken too.
void NameBrokenImages(const std::vector<FrameFiles>& files, tools::Faults& faults) {
  for (const FrameFiles& frame : files) {
    faults.Passed(LoadGreyImage(frame.left));
    if (!frame.right.empty()) faults.Passed(LoadGreyImage(frame.right));
    if (!frame.depth.empty()) faults.Passed(LoadDepthImage(frame.depth));
  }
}

}  // namespace

Result<Image> LoadGreyImage(const std::filesystem::path& file) {
  const Result<cv::Mat> pixels = Decode(file);
  if (!pixels) return pixels.error();
  if (pixels->type() == CV_8UC1) return CopyPixels(*pixels, PixelFormat::kGray8);
  if (pixels->depth() != CV_8U || pixels->channels() < 3) {
    return BadImage(file, "is " + Describe(*pixels) + "; 8-bit grey or colour is needed");
  }
  Image image = WithSize(*pixels, PixelFormat::kGray8);
  image.converted = true;
  const int channels = pixels->channels();
  auto out = image.bytes.begin();
  for (int y = 0; y < pixels->rows; ++y) {
    const uint8_t* bgr = pixels->ptr<uint8_t>(y);
    for (int x = 0; x < pixels->cols; ++x, bgr += channels) {
      *out++ = GreyOf(bgr[2], bgr[1], bgr[0]);
    }
  }
  return image;
}

Result<Image> LoadDepthImage(const std::filesystem::path& file) {
  const Result<cv::Mat> pixels = Decode(file);
  if (!pixels) return pixels.error();
  if (pixels->type() != CV_16UC1) {
    return BadImage(file, "is " + Describe(*pixels) + "; 16-bit depth, one channel, is needed");
  }
  return CopyPixels(*pixels, PixelFormat::kDepth16);
}

Result<std::unique_ptr<FrameSource>> MakeFileFrames(std::vector<FrameFiles> files,
                                                    const ReadOptions& options,
                                                    Recording& recording) {
  const Result<Done> ordered = MakeOrdered(files, recording.name + " (images)", recording.warnings);
  if (!ordered) return ordered.error();
  std::vector<FrameFiles> present;
  std::vector<Utime> times;
  tools::Faults faults;
  for (FrameFiles& frame : files) {
    const bool complete = NameMissingFiles(frame, faults);
    if (!complete) {
      ++recording.skipped_frames;
      continue;
    }
    times.push_back(frame.utime);
    present.push_back(std::move(frame));
  }
  if (present.empty() && (options.skip_missing || faults.empty())) {
    return Error{ErrorCode::kNotFound, recording.name + ": holds no complete frame"};
  }
  const Image first = FirstImage(present, options, faults);
  if (!faults.empty() && !options.skip_missing) {
    NameBrokenImages(present, faults);
    faults.Add(
        {ErrorCode::kNotFound, "restore them, or leave such frames out with --skip-missing"});
    return faults.error();
  }
  if (first.bytes.empty()) return faults.error();
  if (first.converted) {
    recording.notes.emplace_back("images", std::string("colour, converted: ") + kGreyConversion);
  } else {
    recording.notes.emplace_back("images", "8-bit grey, stored as they are");
  }
  CameraCalibration& camera = recording.calibration.camera;
  camera.width = first.width;
  camera.height = first.height;
  const double rate_hz = MedianRateHz(times);
  if (rate_hz > 0) camera.rate_hz = rate_hz;
  return std::unique_ptr<FrameSource>(
      std::make_unique<FileFrames>(std::move(present), first.width, first.height));
}

}  // namespace gw::importer

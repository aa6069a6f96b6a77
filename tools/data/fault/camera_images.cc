#include "tools/data/fault/camera_images.h"

namespace gw::fault {
namespace {

cv::Mat Copy(const ImageView& view) {
  if (view.empty()) return {};
  const int type = view.format == PixelFormat::kDepth16 ? CV_16UC1 : CV_8UC1;
  // OpenCV has no read-only Mat; nobody writes through this one.
  return cv::Mat(view.height, view.width, type, const_cast<uint8_t*>(view.data),
                 static_cast<size_t>(view.stride))
      .clone();
}

ImageView View(const cv::Mat& image) {
  if (image.empty()) return {};
  return {image.data, image.cols, image.rows, static_cast<int>(image.step[0]),
          image.type() == CV_16UC1 ? PixelFormat::kDepth16 : PixelFormat::kGray8};
}

}  // namespace

CameraImages CopyImages(const CameraFrame& frame) {
  return {Copy(frame.left), Copy(frame.right), Copy(frame.depth)};
}

wire::Bytes EncodeWith(CameraFrame frame, const CameraImages& images) {
  frame.left = View(images.left);
  frame.right = View(images.right);
  frame.depth = View(images.depth);
  return wire::Encode(frame);
}

}  // namespace gw::fault

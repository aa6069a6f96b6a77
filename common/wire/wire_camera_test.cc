// CAMERA, whose pixels are not copied, and delivery stamps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <gw_lcm/camera_t.hpp>
#include <gw_lcm/keyframe_t.hpp>
#include <gw_lcm/map_request_t.hpp>
#include <gw_lcm/map_update_t.hpp>

#include "common/wire/generated.h"
#include "common/wire/testing.h"
#include "common/wire/wire.h"

namespace gw::wire {
namespace {

using testing::RandomMessages;

void ExpectSamePixels(const ImageView& a, const ImageView& b) {
  ASSERT_EQ(a.empty(), b.empty());
  if (a.empty()) return;
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.format, b.format);
  for (int row = 0; row < a.height; ++row) {
    EXPECT_EQ(std::memcmp(a.data + row * a.stride, b.data + row * b.stride,
                          static_cast<size_t>(a.width) * BytesPerPixel(a.format)),
              0);
  }
}

TEST(WireCamera, RoundTripKeepsEveryPixel) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Bytes pixels;
    const CameraFrame frame = RandomMessages(seed).Camera(pixels);
    const Bytes bytes = Encode(frame);
    const auto generated = Generated<gw_lcm::camera_t>(bytes);
    EXPECT_EQ(GeneratedBytes(generated), bytes);
    EXPECT_EQ(generated.num_images, 2);
    EXPECT_EQ(generated.images[0].kind, gw_lcm::camera_image_t::KIND_LEFT);
    const auto decoded = Decode<DecodedCamera>(bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(decoded->frame.utime, frame.utime);
    EXPECT_EQ(decoded->frame.seq, frame.seq);
    EXPECT_EQ(decoded->frame.exposure_us, frame.exposure_us);
    EXPECT_EQ(decoded->frame.emitter, frame.emitter);
    ExpectSamePixels(decoded->frame.left, frame.left);
    ExpectSamePixels(decoded->frame.right, frame.right);
    ExpectSamePixels(decoded->frame.depth, frame.depth);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(decoded->frame.depth.data) % 2, 0u) << seed;
    EXPECT_EQ(Encode(decoded->frame), bytes);
  }
}

TEST(WireCamera, TakesTheMessageOverWithoutCopying) {
  Bytes pixels;
  Bytes bytes = Encode(RandomMessages(1).Camera(pixels));
  const uint8_t* begin = bytes.data();
  const uint8_t* end = begin + bytes.size();
  auto decoded = DecodeCamera(std::move(bytes));
  ASSERT_TRUE(decoded.ok());
  const DecodedCamera kept = std::move(*decoded);
  EXPECT_GT(kept.frame.left.data, begin);
  EXPECT_LT(kept.frame.left.data, end);
}

TEST(WireCamera, LooksIntoTheMessageWhereverItLies) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    Bytes pixels;
    const CameraFrame frame = RandomMessages(seed).Camera(pixels);
    const Bytes bytes = Encode(frame);
    for (const size_t shift : {0, 1}) {
      Bytes shifted(shift);
      shifted.insert(shifted.end(), bytes.begin(), bytes.end());
      const auto view = ViewCamera(ByteSpan(shifted).subspan(shift));
      ASSERT_TRUE(view.ok()) << view.error().message;
      ExpectSamePixels(view->frame.left, frame.left);
      ExpectSamePixels(view->frame.right, frame.right);
      ExpectSamePixels(view->frame.depth, frame.depth);
      EXPECT_EQ(reinterpret_cast<uintptr_t>(view->frame.depth.data) % 2, 0u) << seed;
      EXPECT_TRUE(!frame.depth.empty() || view->storage.empty());
    }
    EXPECT_FALSE(ViewCamera(ByteSpan(bytes).first(bytes.size() - 1)).ok());
  }
}

TEST(WireCamera, RefusesImplausibleImages) {
  const auto frame = [] {
    gw_lcm::camera_t m{};
    m.num_images = 2;
    m.images.resize(2);
    m.images[0] = {1, 4, 3, 5, 1, 15, Bytes(15)};
    m.images[1] = {3, 4, 3, 8, 2, 24, Bytes(24)};
    return m;
  };
  ASSERT_TRUE(Decode<DecodedCamera>(GeneratedBytes(frame())).ok());
  const auto refused = [&](const std::string& field, auto change) {
    auto m = frame();
    change(m);
    ExpectRefused<DecodedCamera>(m, field);
  };
  refused("emitter", [](auto& m) { m.emitter = 3; });
  refused("exposure_us", [](auto& m) { m.exposure_us = -1; });
  refused("num_images", [](auto& m) {
    m.num_images = 0;
    m.images.clear();
  });
  refused("images.kind", [](auto& m) { m.images[0].kind = 4; });
  refused("images.kind", [](auto& m) { m.images[1] = m.images[0]; });
  refused("images", [](auto& m) {
    m.images.erase(m.images.begin());
    m.num_images = 1;
  });
  refused("images", [](auto& m) { m.images[1].width = 3; });
  for (const int bad : {0, -1, 8193, std::numeric_limits<int>::max()}) {
    refused("images.width", [bad](auto& m) { m.images[0].width = bad; });
    refused("images.height", [bad](auto& m) { m.images[0].height = bad; });
  }
  refused("images.row_stride", [](auto& m) { m.images[1].row_stride = 7; });
  refused("images.row_stride", [](auto& m) { m.images[0].row_stride = 1 << 20; });
  refused("images.row_stride", [](auto& m) {
    m.images[1].row_stride = 9;
    m.images[1].data.resize(m.images[1].size = 27);
  });
  refused("images.pixel_format", [](auto& m) { m.images[0].pixel_format = 0; });
  refused("images.pixel_format", [](auto& m) {
    m.images[0].pixel_format = 2;
    m.images[0].row_stride = 8;
    m.images[0].data.resize(m.images[0].size = 24);
  });
  refused("images.size", [](auto& m) { m.images[0].data.resize(m.images[0].size = 14); });
  refused("images.size", [](auto& m) { m.images[0].data.resize(m.images[0].size = 16); });
}

TEST(WireCamera, NoDamageCrashes) {
  for (uint64_t seed = 0; seed < 3000; ++seed) {
    Bytes pixels;
    Bytes bytes = Encode(RandomMessages(seed).Camera(pixels));
    CounterRng rng(seed, 1, 0);
    for (uint32_t flips = 1 + rng.Below(4); flips > 0; --flips) {
      bytes[8 + rng.Below(52)] = static_cast<uint8_t>(rng.Below(256));
    }
    if (rng.Below(4) == 0) bytes.resize(rng.Below(static_cast<uint32_t>(bytes.size())));
    const auto decoded = DecodeCamera(std::move(bytes));
    if (!decoded.ok()) continue;
    EXPECT_TRUE(Decode<DecodedCamera>(Encode(decoded->frame)).ok());
  }
}

// Delivery

TEST(WireDelivery, IsStampedIntoTheThreeTypesInPlace) {
  const Delivery delivery{42, 1'600'000'000'000'000, 40};
  Bytes keyframe = Encode(RandomMessages(1).Make<Keyframe>());
  Bytes update = Encode(RandomMessages(2).Make<MapUpdate>());
  Bytes request = Encode(RandomMessages(3).Make<MapRequest>());
  for (Bytes* message : {&keyframe, &update, &request}) {
    SetDelivery(delivery, *message);
    EXPECT_EQ(ReadDelivery(*message), delivery);
    EXPECT_EQ(ReadHeader(*message)->seq, 42);
  }
  const auto generated = Generated<gw_lcm::keyframe_t>(keyframe);
  EXPECT_EQ(generated.seq, delivery.seq);
  EXPECT_EQ(generated.session, delivery.session);
  EXPECT_EQ(generated.oldest_seq, delivery.oldest_seq);
  EXPECT_EQ(Decode<MapUpdate>(update)->seq, 42);
  EXPECT_EQ(Generated<gw_lcm::map_update_t>(update).oldest_seq, 40);
  EXPECT_EQ(Generated<gw_lcm::map_request_t>(request).session, delivery.session);
}

TEST(WireDelivery, OtherMessagesHaveNone) {
  EXPECT_FALSE(ReadDelivery(Encode(RandomMessages(1).Make<DrState>())));
  EXPECT_FALSE(ReadDelivery(Bytes(10)));
  EXPECT_FALSE(ReadDelivery({}));
  EXPECT_FALSE(ReadHeader(Bytes(23)));
}

}  // namespace
}  // namespace gw::wire

#include "tools/data/foxglove/translator.h"

#include <gtest/gtest.h>

#include <set>

#include "common/wire/channels.h"
#include "common/wire/testing.h"
#include "tools/data/files/json.h"

namespace gw::foxglove {
namespace {

std::vector<Json> Of(const std::vector<Message>& messages, Topic topic) {
  std::vector<Json> found;
  for (const Message& m : messages) {
    if (m.topic == topic) found.push_back(Json::parse(*m.json));
  }
  return found;
}

FramePose PoseAt(double x, int64_t ms) {
  FramePose pose;
  pose.utime = Utime{ms * 1000};
  pose.status = TrackingStatus::kTracking;
  pose.T_WB = SE3(Eigen::Quaterniond::Identity(), {x, 0, 0});
  return pose;
}

// Every required property of the schema is there, everywhere.
void ExpectFits(const Json& schema, const Json& value, const std::string& where) {
  const std::string type = schema.value("type", "");
  if (type == "object") {
    ASSERT_TRUE(value.is_object()) << where;
    for (const Json& name : schema.value("required", Json::array())) {
      EXPECT_TRUE(value.contains(name.get<std::string>())) << where << "." << name;
    }
    for (const auto& [name, part] : value.items()) {
      ASSERT_TRUE(schema["properties"].contains(name)) << where << "." << name;
      ExpectFits(schema["properties"][name], part, where + "." + name);
    }
  } else if (type == "array") {
    ASSERT_TRUE(value.is_array()) << where;
    for (const Json& part : value) ExpectFits(schema["items"], part, where + "[]");
  } else if (type == "number") {
    EXPECT_TRUE(value.is_number()) << where << " " << value;
  } else if (type == "integer" || schema.contains("oneOf")) {
    EXPECT_TRUE(value.is_number_integer()) << where << " " << value;
  } else if (type == "string") {
    EXPECT_TRUE(value.is_string()) << where;
  } else if (type == "boolean") {
    EXPECT_TRUE(value.is_boolean()) << where;
  } else {
    ADD_FAILURE() << where << ": no type in the schema";
  }
}

TranslatorOptions WithFloor() {
  TranslatorOptions options;
  options.floor = FloorCells{3, 2, 0.05, {0, 0}, {1, 0, 0, 0, 0, 1}};
  options.camera.emplace();
  options.camera->rectified.width = 640;
  options.camera->rectified.height = 480;
  return options;
}

TEST(Translator, EveryMessageFitsItsSchema) {
  Translator translator(WithFloor());
  wire::testing::RandomMessages random(1);
  std::vector<Message> all;
  const auto keep = [&all](std::vector<Message> some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  for (int i = 1; i <= 300; ++i) {
    const Utime now{i * 40'000};
    wire::Bytes pixels;
    CameraFrame frame = random.Camera(pixels);
    FramePose pose = random.Make<FramePose>();
    FrameDetail detail = random.Make<FrameDetail>();
    GroundTruth truth = random.Make<GroundTruth>();
    Pose control = random.Make<Pose>();
    frame.utime = pose.utime = detail.utime = truth.utime = control.utime = now;
    translator.Take(wire::kGroundTruth, wire::Encode(truth), now);
    translator.Take(wire::kCamera, wire::Encode(frame), now);
    translator.Take(wire::kFrameDetail, wire::Encode(detail), now);
    translator.Take(wire::kFramePose, wire::Encode(pose), now);
    translator.Take(wire::kPose, wire::Encode(control), now);
    translator.Take(wire::kDr, wire::Encode(random.Make<DrState>()), now);
    translator.Take(wire::kKeyframe, wire::Encode(random.Make<Keyframe>()), now);
    translator.Take(wire::kMapUpdate, wire::Encode(random.Make<MapUpdate>()), now);
    translator.Take(wire::kHealth, wire::Encode(random.Make<Health>()), now);
    translator.Take(wire::kNote, wire::Encode(random.Make<wire::Note>()), now);
    translator.Tick(now);
    keep(translator.Drain());
  }
  std::set<Topic> seen;
  for (size_t i = 0; i < kNumTopics; ++i) keep(translator.State(static_cast<Topic>(i)));
  for (const Message& message : all) {
    seen.insert(message.topic);
    const auto& info = Info(message.topic);
    ExpectFits(Json::parse(SchemaText(info.schema_name)), Json::parse(*message.json),
               std::string(info.name));
    if (::testing::Test::HasFatalFailure()) return;
  }
  EXPECT_EQ(seen.size(), kNumTopics - 1);  // all but that of the viewer itself
}

TEST(Translator, PosesAndImagesAreLimitedInRate) {
  Translator translator({});
  size_t images = 0, poses = 0;
  wire::testing::RandomMessages random(2);
  for (int64_t ms = 0; ms < 1000; ms += 5) {
    Pose pose = random.Make<Pose>();
    pose.utime = Utime{ms * 1000};
    translator.Take(wire::kPose, wire::Encode(pose), pose.utime);
    wire::Bytes pixels;
    CameraFrame frame = random.Camera(pixels);
    translator.Take(wire::kCamera, wire::Encode(frame), pose.utime);
    const auto messages = translator.Drain();
    images += Of(messages, Topic::kImage).size();
    poses += Of(messages, Topic::kPose).size();
  }
  EXPECT_EQ(images, 10u);
  EXPECT_GE(poses, 28u);
  EXPECT_LE(poses, 31u);
}

TEST(Translator, WhatNobodyWantsIsNotMade) {
  Translator translator({});
  translator.SetWanted({});
  translator.Take(wire::kFramePose, wire::Encode(PoseAt(1, 1)), {1000});
  EXPECT_TRUE(translator.Drain().empty());
  // The state is kept for one who comes later.
  EXPECT_GE(translator.State(Topic::kTrajectory).size(), 2u);
}

TEST(Translator, ErrorIsZeroForThePerfectPoseInAnotherFrame) {
  Translator translator({});
  const SE3 T_GW(Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ())), {5, 6, 0});
  std::vector<Json> errors;
  for (int i = 0; i < 100; ++i) {
    const FramePose pose = PoseAt(0.05 * i, 100 + i * 100);
    GroundTruth truth;
    truth.utime = pose.utime;
    truth.seq = i + 1;
    truth.T_GB = T_GW * pose.T_WB;
    translator.Take(wire::kGroundTruth, wire::Encode(truth), truth.utime);
    translator.Take(wire::kFramePose, wire::Encode(pose), pose.utime);
    for (Json& e : Of(translator.Drain(), Topic::kError)) errors.push_back(std::move(e));
  }
  ASSERT_GT(errors.size(), 50u);
  EXPECT_LT(errors.back()["position_m"].get<double>(), 1e-9);
  EXPECT_LT(std::abs(errors.back()["heading_deg"].get<double>()), 1e-6);
}

TEST(Translator, AProcessThatFallsSilentIsNamed) {
  Translator translator({});
  Health health;
  health.process = "gw-frontend";
  health.state = HealthState::kOk;
  translator.Take(wire::kHealth, wire::Encode(health), {1'000'000});
  translator.Tick({2'000'000});
  EXPECT_EQ(Of(translator.Drain(), Topic::kHealth).back()["state"], "ok");
  translator.Tick({6'000'000});
  const Json silent = Of(translator.Drain(), Topic::kHealth).back();
  EXPECT_EQ(silent["state"], "silent");
  EXPECT_NE(silent["action"].get<std::string>().find("systemctl status gw-frontend"),
            std::string::npos);
}

TEST(Translator, LossAndBadMessagesAreCounted) {
  Translator translator({});
  FramePose pose = PoseAt(0, 1);
  pose.seq = 5;
  translator.Take(wire::kFramePose, wire::Encode(pose), {1});
  pose.seq = 9;
  translator.Take(wire::kFramePose, wire::Encode(pose), {2});
  translator.Take(wire::kFramePose, wire::Bytes(100, 7), {3});
  translator.Take(wire::kFramePose, {}, {4});
  const auto& count = translator.channels().at(wire::kFramePose);
  EXPECT_EQ(count.lost, 3);
  EXPECT_EQ(count.undecodable, 2);
}

TEST(Translator, ALoopIsLogged) {
  Translator translator({});
  MapUpdate update;
  update.snapshot = true;
  update.revision = 1;
  update.keyframes = {{{1}, {0}, SE3()}, {{9}, {0}, SE3()}};
  update.loops = {{{9}, {1}, true, SE3(Eigen::Quaterniond::Identity(), {0.25, 0, 0})}};
  translator.Take(wire::kMapUpdate, wire::Encode(update), {1});
  const auto log = Of(translator.Drain(), Topic::kLog);
  ASSERT_EQ(log.size(), 1u);
  EXPECT_EQ(log[0]["message"],
            "loop closed: keyframe 9 is where 1 was; corrected by 0.250 m, 0.00 deg");
}

}  // namespace
}  // namespace gw::foxglove

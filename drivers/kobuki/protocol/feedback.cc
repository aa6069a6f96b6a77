#include "drivers/kobuki/protocol/feedback.h"

#include "drivers/common/bytes.h"
#include "drivers/kobuki/protocol/frame.h"

namespace gw::kobuki {
namespace {

using Bytes = std::span<const uint8_t>;

// Each reader gives nothing when the length is not the one of its sub-payload.

std::optional<BasicData> ReadBasic(Bytes d) {
  if (d.size() != 15) return std::nullopt;
  BasicData out;
  out.timestamp_ms = ReadU16(d, 0);
  out.bumper = d[2];
  out.wheel_drop = d[3];
  out.cliff = d[4];
  out.left_encoder = ReadU16(d, 5);
  out.right_encoder = ReadU16(d, 7);
  out.left_pwm = static_cast<int8_t>(d[9]);
  out.right_pwm = static_cast<int8_t>(d[10]);
  out.buttons = d[11];
  out.charger = d[12];
  out.battery_dv = d[13];
  out.over_current = d[14];
  return out;
}

std::optional<DockingIr> ReadDockingIr(Bytes d) {
  if (d.size() != 3) return std::nullopt;
  return DockingIr{d[0], d[1], d[2]};
}

std::optional<Inertial> ReadInertial(Bytes d) {
  if (d.size() != 7) return std::nullopt;
  return Inertial{ReadI16(d, 0), ReadI16(d, 2)};
}

std::optional<CliffAdc> ReadCliff(Bytes d) {
  if (d.size() != 6) return std::nullopt;
  return CliffAdc{ReadU16(d, 0), ReadU16(d, 2), ReadU16(d, 4)};
}

std::optional<MotorCurrent> ReadCurrent(Bytes d) {
  if (d.size() != 2) return std::nullopt;
  return MotorCurrent{d[0], d[1]};
}

// The oldest firmware sends a two-byte number: 104 is 1.0.4.
Version FromShortForm(uint16_t number) {
  return {number / 100, number / 10 % 10, number % 10};
}

std::optional<Version> ReadVersion(Bytes d) {
  if (d.size() == 2) return FromShortForm(ReadU16(d, 0));
  if (d.size() != 4) return std::nullopt;
  return Version{d[2], d[1], d[0]};
}

std::optional<Version> ReadFirmwareVersion(Bytes d) {
  if (d.size() != 2) return ReadVersion(d);
  switch (const uint16_t number = ReadU16(d, 0)) {
    case 123:
      return Version{1, 0, 0};
    case 10100:
      return Version{1, 1, 0};
    case 10101:
      return Version{1, 1, 1};
    default:
      return FromShortForm(number);
  }
}

std::optional<RawGyro> ReadRawGyro(Bytes d) {
  if (d.size() < 8) return std::nullopt;
  const size_t num_words = d[1];
  if (d.size() != 2 + 2 * num_words || num_words % 3 != 0 || num_words > 3 * kMaxGyroSamples) {
    return std::nullopt;
  }
  RawGyro out{d[0], {}};
  for (size_t at = 2; at < d.size(); at += 6) {
    out.samples.push_back({ReadI16(d, at), ReadI16(d, at + 2), ReadI16(d, at + 4)});
  }
  return out;
}

std::optional<GpInput> ReadGpInput(Bytes d) {
  if (d.size() != 16) return std::nullopt;
  return GpInput{ReadU16(d, 0), {ReadU16(d, 2), ReadU16(d, 4), ReadU16(d, 6), ReadU16(d, 8)}};
}

std::optional<Udid> ReadUdid(Bytes d) {
  if (d.size() != 12) return std::nullopt;
  return Udid{{ReadU32(d, 0), ReadU32(d, 4), ReadU32(d, 8)}};
}

std::optional<ControllerInfo> ReadControllerInfo(Bytes d) {
  if (d.size() != 13) return std::nullopt;
  return ControllerInfo{d[0], ReadU32(d, 1), ReadU32(d, 5), ReadU32(d, 9)};
}

}  // namespace

Feedback DecodeFeedback(Bytes payload) {
  Feedback out;
  const auto parts = SplitPayload(payload);
  if (!parts) return out;
  const auto keep = [&out](auto read, auto* field) {
    if (read) {
      *field = std::move(read);
    } else {
      ++out.bad_length;
    }
  };
  for (const SubPayload& part : *parts) {
    switch (static_cast<FeedbackId>(part.id)) {
      case FeedbackId::kBasic:
        keep(ReadBasic(part.data), &out.basic);
        break;
      case FeedbackId::kDockingIr:
        keep(ReadDockingIr(part.data), &out.docking_ir);
        break;
      case FeedbackId::kInertial:
        keep(ReadInertial(part.data), &out.inertial);
        break;
      case FeedbackId::kCliff:
        keep(ReadCliff(part.data), &out.cliff);
        break;
      case FeedbackId::kCurrent:
        keep(ReadCurrent(part.data), &out.current);
        break;
      case FeedbackId::kHardwareVersion:
        keep(ReadVersion(part.data), &out.hardware);
        break;
      case FeedbackId::kFirmwareVersion:
        keep(ReadFirmwareVersion(part.data), &out.firmware);
        break;
      case FeedbackId::kRawGyro:
        keep(ReadRawGyro(part.data), &out.raw_gyro);
        break;
      case FeedbackId::kGpInput:
        keep(ReadGpInput(part.data), &out.gp_input);
        break;
      case FeedbackId::kUdid:
        keep(ReadUdid(part.data), &out.udid);
        break;
      case FeedbackId::kControllerInfo:
        keep(ReadControllerInfo(part.data), &out.controller);
        break;
      default:
        ++out.unknown;
    }
  }
  return out;
}

}  // namespace gw::kobuki

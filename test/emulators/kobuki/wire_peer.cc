#include "test/emulators/kobuki/wire_peer.h"

#include "drivers/common/bytes.h"
#include "drivers/kobuki/protocol/frame.h"

namespace gw::kobuki {
namespace {

void Append(FeedbackId id, const std::vector<uint8_t>& data, std::vector<uint8_t>* out) {
  out->push_back(static_cast<uint8_t>(id));
  out->push_back(static_cast<uint8_t>(data.size()));
  out->insert(out->end(), data.begin(), data.end());
}

std::vector<uint8_t> VersionData(const Version& v, VersionForm form) {
  if (form == VersionForm::kTwoBytes) {
    std::vector<uint8_t> data;
    AppendU16(static_cast<uint16_t>(v.major * 100 + v.minor * 10 + v.patch), &data);
    return data;
  }
  return {static_cast<uint8_t>(v.patch), static_cast<uint8_t>(v.minor),
          static_cast<uint8_t>(v.major), 0};
}

}  // namespace

std::vector<uint8_t> EncodeFeedback(const Feedback& f, VersionForm form) {
  std::vector<uint8_t> out;
  if (f.basic) {
    const BasicData& b = *f.basic;
    std::vector<uint8_t> data;
    AppendU16(b.timestamp_ms, &data);
    data.insert(data.end(), {b.bumper, b.wheel_drop, b.cliff});
    AppendU16(b.left_encoder, &data);
    AppendU16(b.right_encoder, &data);
    data.insert(data.end(), {static_cast<uint8_t>(b.left_pwm), static_cast<uint8_t>(b.right_pwm),
                             b.buttons, b.charger, b.battery_dv, b.over_current});
    Append(FeedbackId::kBasic, data, &out);
  }
  if (f.docking_ir) {
    Append(FeedbackId::kDockingIr, {f.docking_ir->right, f.docking_ir->centre, f.docking_ir->left},
           &out);
  }
  if (f.inertial) {
    std::vector<uint8_t> data;
    AppendI16(f.inertial->angle_cdeg, &data);
    AppendI16(f.inertial->rate_cdeg_s, &data);
    data.insert(data.end(), {0, 0, 0});
    Append(FeedbackId::kInertial, data, &out);
  }
  if (f.cliff) {
    std::vector<uint8_t> data;
    for (const uint16_t adc : {f.cliff->right, f.cliff->centre, f.cliff->left}) {
      AppendU16(adc, &data);
    }
    Append(FeedbackId::kCliff, data, &out);
  }
  if (f.current) {
    Append(FeedbackId::kCurrent, {f.current->left_10ma, f.current->right_10ma}, &out);
  }
  if (f.raw_gyro) {
    std::vector<uint8_t> data = {f.raw_gyro->first_id,
                                 static_cast<uint8_t>(3 * f.raw_gyro->samples.size())};
    for (const auto& sample : f.raw_gyro->samples) {
      for (const int16_t axis : sample) AppendI16(axis, &data);
    }
    Append(FeedbackId::kRawGyro, data, &out);
  }
  if (f.gp_input) {
    std::vector<uint8_t> data;
    AppendU16(f.gp_input->digital, &data);
    for (const uint16_t adc : f.gp_input->analog) AppendU16(adc, &data);
    data.insert(data.end(), {0xF0, 0x0F, 0, 0, 0, 0});
    Append(FeedbackId::kGpInput, data, &out);
  }
  if (f.hardware) Append(FeedbackId::kHardwareVersion, VersionData(*f.hardware, form), &out);
  if (f.firmware) Append(FeedbackId::kFirmwareVersion, VersionData(*f.firmware, form), &out);
  if (f.udid) {
    std::vector<uint8_t> data;
    for (const uint32_t word : f.udid->words) AppendU32(word, &data);
    Append(FeedbackId::kUdid, data, &out);
  }
  if (f.controller) {
    std::vector<uint8_t> data = {f.controller->type};
    for (const uint32_t gain :
         {f.controller->p_milli, f.controller->i_milli, f.controller->d_milli}) {
      AppendU32(gain, &data);
    }
    Append(FeedbackId::kControllerInfo, data, &out);
  }
  return out;
}

Commands DecodeCommands(const std::vector<uint8_t>& payload) {
  Commands out;
  const auto parts = SplitPayload(payload);
  if (!parts) return out;
  for (const auto& [id, d] : *parts) {
    switch (static_cast<CommandId>(id)) {
      case CommandId::kBaseControl:
        if (d.size() == 4) out.drive = BaseControl{ReadI16(d, 0), ReadI16(d, 2)};
        break;
      case CommandId::kSound:
        if (d.size() == 3) out.sound = SoundCommand{ReadU16(d, 0), d[2]};
        break;
      case CommandId::kSoundSequence:
        if (d.size() == 1) out.sound_sequence = d[0];
        break;
      case CommandId::kRequestExtra:
        if (d.size() == 2) out.request = ReadU16(d, 0);
        break;
      case CommandId::kOutput:
        if (d.size() == 2) out.output = ReadU16(d, 0);
        break;
      case CommandId::kSetGains:
        if (d.size() == 13) {
          out.set_gains = ControllerInfo{d[0], ReadU32(d, 1), ReadU32(d, 5), ReadU32(d, 9)};
        }
        break;
      case CommandId::kGetGains:
        if (d.size() == 1) out.get_gains = true;
        break;
    }
  }
  return out;
}

}  // namespace gw::kobuki

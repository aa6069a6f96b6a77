#include "tools/data/fault/fault_injector.h"

#include <algorithm>
#include <utility>

#include "common/wire/channels.h"
#include "tools/data/fault/image_faults.h"
#include "tools/data/fault/motion_faults.h"
#include "tools/data/fault/named_faults.h"

namespace gw::fault {
namespace {

bool IsEstimate(std::string_view channel) {
  return wire::FindChannel(channel) != nullptr && channel != wire::kCamera &&
         channel != wire::kImu && channel != wire::kWheel && channel != wire::kDr &&
         channel != wire::kGroundTruth && channel != wire::kBaseCommand && channel != wire::kNote;
}

}  // namespace

class FaultInjector::Impl {
 public:
  Impl(FaultPlan plan, Sink sink)
      : plan_(std::move(plan)),
        sink_(std::move(sink)),
        images_(plan_),
        named_(plan_.named, plan_.optics) {}

  Result<Done> Add(const process::LogEvent& event) {
    if (!begin_) begin_ = event.received;
    const std::string channel(event.channel);
    const DurationUs t = event.received - *begin_;
    if (channel == wire::kNote) return AddNote(event, t);
    if (!edits_noted_) {
      Result<Done> noted = NoteEdits(event.received);
      if (!noted) return noted;
    }
    if (IsEstimate(channel)) {
      ++summary_.left_out;
      return Done{};
    }
    const bool cut = std::any_of(plan_.teleport.begin(), plan_.teleport.end(),
                                 [t](const tools::Span& s) { return s.Contains(t); });
    std::optional<wire::Bytes> message = Edit(channel, event.data, t, cut);
    if (cut) {
      ++summary_.teleported;
      ++removed_[channel];
      return Done{};
    }
    if (!message) return Done{};
    DurationUs delay;
    const auto delayed = plan_.delay.find(channel);
    if (delayed != plan_.delay.end()) {
      delay = delayed->second;
      ++summary_.delayed;
    }
    const Utime received = event.received - CutBefore(t);
    if (!named_.Concerns(channel)) return Queue(received, delay, channel, *std::move(message));
    return QueueNamed(received, t, delay, channel, *std::move(message));
  }

  Result<FaultSummary> Finish() {
    if (!edits_noted_) {
      Result<Done> noted = NoteEdits(begin_.value_or(Utime{}));
      if (!noted) return noted.error();
    }
    const Result<Done> flushed = WriteUntil(std::nullopt);
    if (!flushed) return flushed.error();
    return summary_;
  }

 private:
  struct Pending {
    std::string channel;
    wire::Bytes message;
  };

  // Total length of the teleports in front of t (part of one when t lies inside).
  DurationUs CutBefore(DurationUs t) const {
    DurationUs total;
    for (const tools::Span& span : plan_.teleport) {
      if (t > span.begin) total = total + (std::min(t, span.end) - span.begin);
    }
    return total;
  }

  double SlipFactor(DurationUs t) const {
    double factor = 1;
    for (const Slip& slip : plan_.slip) {
      if (slip.span.Contains(t)) factor *= slip.factor;
    }
    return factor;
  }

  // The message to write; empty when it is lost. With cut the message only moves the state on.
  std::optional<wire::Bytes> Edit(const std::string& channel, wire::ByteSpan data, DurationUs t,
                                  bool cut) {
    const DurationUs shift = CutBefore(t);
    const int64_t removed = removed_[channel];
    const bool moved = shift.us != 0 || removed != 0;
    const auto keep = [&] { return wire::Bytes(data.begin(), data.end()); };
    // Decodes, edits, and moves in time; messages that cannot be decoded pass unchanged.
    const auto edit = [&]<typename T>(const auto& change) -> wire::Bytes {
      Result<T> decoded = wire::Decode<T>(data);
      if (!decoded) {
        ++summary_.undecodable;
        return keep();
      }
      T out = change(*decoded);
      out.utime = out.utime - shift;
      out.seq -= removed;
      return wire::Encode(out);
    };
    const double slip = SlipFactor(t);
    if (channel == wire::kImu && (moved || plan_.gyro_bias_rad_s != 0)) {
      return edit.operator()<ImuSample>([&](ImuSample sample) {
        sample.w_I_rad_s.array() += plan_.gyro_bias_rad_s;
        summary_.biased += !cut && plan_.gyro_bias_rad_s != 0 ? 1 : 0;
        return sample;
      });
    }
    if (channel == wire::kWheel && EditsMotion()) {
      return edit.operator()<WheelSample>([&](const WheelSample& sample) {
        WheelSample out = wheels_.Apply(sample, slip, cut);
        summary_.slipped += !cut && slip != 1 ? 1 : 0;
        // Behind a teleport the first interval begins where the output ended.
        const DurationUs begin_shift = CutBefore(sample.utime_begin - *begin_);
        const bool across = begin_shift != shift && last_wheel_.has_value();
        out.utime_begin = across ? *last_wheel_ : sample.utime_begin - begin_shift;
        if (!cut) last_wheel_ = sample.utime - shift;
        return out;
      });
    }
    if (channel == wire::kDr && EditsMotion()) {
      return edit.operator()<DrState>([&](const DrState& state) {
        summary_.slipped += !cut && slip != 1 ? 1 : 0;
        return dr_.Apply(state, slip, cut);
      });
    }
    if (channel == wire::kGroundTruth && moved) {
      return edit.operator()<GroundTruth>([](const GroundTruth& truth) { return truth; });
    }
    if (channel == wire::kBaseCommand && moved) {
      return edit.operator()<BaseCommand>([](const BaseCommand& command) { return command; });
    }
    if (channel == wire::kCamera) return EditCamera(data, t, shift, removed, cut);
    return keep();
  }

  bool EditsMotion() const { return !plan_.slip.empty() || !plan_.teleport.empty(); }

  std::optional<wire::Bytes> EditCamera(wire::ByteSpan data, DurationUs t, DurationUs shift,
                                        int64_t removed, bool cut) {
    wire::Bytes raw(data.begin(), data.end());
    const std::optional<wire::Header> header = wire::ReadHeader(data);
    if (!cut && header && images_.Lost(t, header->seq)) {
      ++summary_.dropped_frames;
      return std::nullopt;
    }
    images_.Remember(t, raw);
    if (cut || (!images_.Touches(t) && shift.us == 0 && removed == 0)) return raw;
    const Result<wire::DecodedCamera> camera = wire::DecodeCamera(raw);
    if (!camera) {
      ++summary_.undecodable;
      return raw;
    }
    CameraFrame frame = camera->frame;
    frame.utime = frame.utime - shift;
    frame.seq -= removed;
    return images_.Apply(t, frame, summary_);
  }

  Result<Done> AddNote(const process::LogEvent& event, DurationUs t) {
    Result<wire::Note> note = wire::Decode<wire::Note>(event.data);
    if (!note) {
      ++summary_.undecodable;
      return Done{};
    }
    return WriteNote(event.received - CutBefore(t), *std::move(note));
  }
  Result<Done> NoteEdits(Utime utime) {
    edits_noted_ = true;
    for (const auto& [key, text] : plan_.Describe()) {
      Result<Done> written = WriteNote(utime, {utime, 0, key, text});
      if (!written) return written;
    }
    return Done{};
  }
  Result<Done> WriteNote(Utime received, wire::Note note) {
    note.utime = received;
    note.seq = ++note_seq_;
    return Queue(received, {}, wire::kNote, wire::Encode(note));
  }

  // What the named faults make of the message.
  Result<Done> QueueNamed(Utime received, DurationUs t, DurationUs delay,
                          const std::string& channel, wire::Bytes message) {
    auto edited = named_.Apply(channel, t, message);
    if (!edited) {
      ++summary_.undecodable;
      return Queue(received, delay, channel, std::move(message));
    }
    ++summary_.named;
    for (NamedFaults::Message& out : *edited) {
      Result<Done> queued = Queue(received, delay + out.delay, channel, std::move(out.bytes));
      if (!queued) return queued;
    }
    return Done{};
  }

  // Delayed messages wait until the others have caught up.
  Result<Done> Queue(Utime received, DurationUs delay, const std::string& channel,
                     wire::Bytes message) {
    Result<Done> written = WriteUntil(received);
    if (!written) return written;
    pending_.emplace(received + delay, Pending{channel, std::move(message)});
    return Done{};
  }
  Result<Done> WriteUntil(std::optional<Utime> received) {
    while (!pending_.empty() && (!received || pending_.begin()->first < *received)) {
      const auto next = pending_.begin();
      Result<Done> written = sink_(next->first, next->second.channel, next->second.message);
      if (!written) return written;
      ++summary_.events;
      pending_.erase(next);
    }
    return Done{};
  }

  const FaultPlan plan_;
  const Sink sink_;
  ImageFaults images_;
  WheelFaults wheels_;
  DrFaults dr_;
  NamedFaults named_;
  FaultSummary summary_;
  std::optional<Utime> begin_;              // of the input log
  std::optional<Utime> last_wheel_;         // end of the last wheel interval written
  std::map<std::string, int64_t> removed_;  // per channel, by teleports
  std::multimap<Utime, Pending> pending_;   // equal times stay in the order in which they came
  int64_t note_seq_ = 0;
  bool edits_noted_ = false;
};

FaultInjector::FaultInjector(FaultPlan plan, Sink sink)
    : impl_(std::make_unique<Impl>(std::move(plan), std::move(sink))) {}
FaultInjector::FaultInjector(FaultInjector&&) noexcept = default;
FaultInjector::~FaultInjector() = default;

Result<Done> FaultInjector::Add(const process::LogEvent& event) {
  return impl_->Add(event);
}
Result<FaultSummary> FaultInjector::Finish() {
  return impl_->Finish();
}

}  // namespace gw::fault

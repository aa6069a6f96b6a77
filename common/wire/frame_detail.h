// FRAME_DETAIL, as wire.h for the other messages.
#pragma once

#include "common/contract/frame_detail.h"
#include "common/wire/wire.h"

namespace gw::wire {

Bytes Encode(const FrameDetail& detail);
template <>
Result<FrameDetail> Decode(ByteSpan message);

}  // namespace gw::wire

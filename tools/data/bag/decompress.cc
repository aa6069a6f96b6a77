#include "tools/data/bag/decompress.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>

namespace gw::bag {
namespace {

constexpr size_t kStep = size_t{1} << 18;  // bytes that one call may write

// Calls step(output, room) until it says that it is done or until the limit is reached. step
// returns how many bytes it wrote, and sets done or a problem.
template <typename Step>
Decompressed Collect(uint64_t limit, Step step) {
  Decompressed out;
  bool done = false;
  while (!done && out.problem.empty()) {
    const size_t before = out.bytes.size();
    const size_t room = static_cast<size_t>(std::min<uint64_t>(kStep, limit - before + 1));
    out.bytes.resize(before + room);
    const size_t written = step(out.bytes.data() + before, room, done, out.problem);
    out.bytes.resize(before + written);
    if (out.bytes.size() > limit) {
      out.bytes.resize(limit);
      out.problem = "holds more than it states";
    }
  }
  return out;
}

Decompressed Bunzip(Bytes input, uint64_t limit) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return {{}, "bz2 cannot start"};
  // libbz2 reads its input through a pointer that is not const, and does not write to it.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(input.data()));
  stream.avail_in = static_cast<unsigned>(std::min<size_t>(input.size(), UINT32_MAX));
  Decompressed out =
      Collect(limit, [&](uint8_t* data, size_t room, bool& done, std::string& problem) {
        stream.next_out = reinterpret_cast<char*>(data);
        stream.avail_out = static_cast<unsigned>(room);
        const int code = BZ2_bzDecompress(&stream);
        const size_t written = room - stream.avail_out;
        done = code == BZ_STREAM_END;
        if (!done && code != BZ_OK) {
          problem = "its bz2 data are damaged";
        } else if (!done && written == 0 && stream.avail_in == 0) {
          problem = "its bz2 data end early";
        }
        return written;
      });
  BZ2_bzDecompressEnd(&stream);
  return out;
}

Decompressed Unlz4(Bytes input, uint64_t limit) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0u) {
    return {{}, "lz4 cannot start"};
  }
  Decompressed out =
      Collect(limit, [&](uint8_t* data, size_t room, bool& done, std::string& problem) {
        size_t written = room;
        size_t read = input.size();
        const size_t code = LZ4F_decompress(context, data, &written, input.data(), &read, nullptr);
        input = input.subspan(read);
        if (LZ4F_isError(code) != 0u) {
          problem = std::string("its lz4 data are damaged (") + LZ4F_getErrorName(code) + ")";
          return size_t{0};
        }
        done = code == 0 && input.empty();
        if (code != 0 && written == 0 && read == 0) problem = "its lz4 data end early";
        return written;
      });
  LZ4F_freeDecompressionContext(context);
  return out;
}

Decompressed Unzstd(Bytes input, uint64_t limit) {
  ZSTD_DStream* const stream = ZSTD_createDStream();
  if (stream == nullptr) return {{}, "zstd cannot start"};
  ZSTD_inBuffer in{input.data(), input.size(), 0};
  Decompressed out =
      Collect(limit, [&](uint8_t* data, size_t room, bool& done, std::string& problem) {
        ZSTD_outBuffer to{data, room, 0};
        const size_t before = in.pos;
        const size_t code = ZSTD_decompressStream(stream, &to, &in);
        if (ZSTD_isError(code) != 0u) {
          problem = std::string("its zstd data are damaged (") + ZSTD_getErrorName(code) + ")";
          return to.pos;
        }
        done = code == 0 && in.pos == in.size;
        if (!done && to.pos == 0 && in.pos == before) problem = "its zstd data end early";
        return to.pos;
      });
  ZSTD_freeDStream(stream);
  return out;
}

}  // namespace

Decompressed Decompress(const std::string& compression, Bytes input, uint64_t limit) {
  if (compression.empty() || compression == "none") {
    const Bytes used = input.first(static_cast<size_t>(std::min<uint64_t>(input.size(), limit)));
    return {{used.begin(), used.end()}, ""};
  }
  if (compression == "bz2") return Bunzip(input, limit);
  if (compression == "lz4") return Unlz4(input, limit);
  if (compression == "zstd") return Unzstd(input, limit);
  return {{}, "its compression '" + compression + "' is not known"};
}

}  // namespace gw::bag

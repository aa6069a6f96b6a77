// Spoils bags at random and imports them, as many bytes per reader as are asked for: whatever comes
// out, nothing crashes, hangs or is read beyond its end. Under the sanitizers this is the proof;
// without them it finds crashes alone.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/core/random.h"
#include "tools/data/bag/bag.h"
#include "tools/data/import/rosbag.h"

namespace gw::importer {
namespace {

namespace fs = std::filesystem;

using Content = std::vector<uint8_t>;

struct Reader {
  const char* name;
  std::vector<const char*> bags;
  const char* spoilt_name;  // the importer looks at what is in a file, SQLite at its name too
};

Content BytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

size_t Below(CounterRng& rng, size_t n) {
  return rng.Below(static_cast<uint32_t>(n));
}

// Bytes that parsers trip over: lengths that are zero, enormous or negative.
void WriteLength(CounterRng& rng, Content& bytes, size_t at) {
  constexpr uint32_t kLengths[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0xfffffff0, 0x10000};
  const uint32_t length = kLengths[rng.Below(std::size(kLengths))];
  for (size_t i = 0; i < 4 && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<uint8_t>(length >> (8 * i));
  }
}

// A block of the file over, or into, another place of it.
void Splice(CounterRng& rng, Content& bytes) {
  const size_t size = 1 + Below(rng, std::min<size_t>(bytes.size() / 2, 4096));
  const size_t from = Below(rng, bytes.size() - size);
  const Content block(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                      bytes.begin() + static_cast<std::ptrdiff_t>(from + size));
  const size_t to = Below(rng, bytes.size() - size);
  const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(to);
  if (rng.Below(2) == 0) {
    std::copy(block.begin(), block.end(), at);
  } else {
    bytes.insert(at, block.begin(), block.end());
  }
}

Content Spoilt(Content bytes, CounterRng& rng) {
  for (uint32_t k = 1 + rng.Below(12); k > 0; --k) {
    const size_t at = Below(rng, bytes.size());
    switch (rng.Below(6)) {
      case 0:
        WriteLength(rng, bytes, at);
        break;
      case 1:
        Splice(rng, bytes);
        break;
      case 2:
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(
                                        std::min(bytes.size() - 1, at + rng.Below(64))));
        break;
      default:
        bytes[at] = static_cast<uint8_t>(rng.Below(256));
    }
  }
  if (rng.Below(4) == 0) bytes.resize(1 + Below(rng, bytes.size()));
  return bytes;
}

struct Outcome {
  size_t bytes = 0, files = 0, imported = 0, images = 0;
};

void Import(const fs::path& file, Outcome& outcome) {
  const auto recording = ReadRosbag(file, {});
  if (!recording) return;
  ++outcome.imported;
  if (!recording->frames) return;
  for (size_t i = 0; i < recording->frames->size(); ++i) {
    outcome.images += recording->frames->Load(i).ok() ? 1 : 0;
  }
}

void ReadEverything(const fs::path& file) {
  const auto bag = bag::Bag::Open(file);
  if (!bag) return;
  for (const bag::MessageRef& message : (*bag)->messages()) (void)(*bag)->Read(message).ok();
}

int Main(size_t bytes_per_reader) {
  const fs::path bags = fs::path(GW_SOURCE_DIR) / "tools/data/bag/testing/bags";
  const std::vector<Reader> readers = {
      {"ROS 1", {"ros1_none.bag", "ros1_bz2.bag", "ros1_lz4.bag"}, "s.bag"},
      {"MCAP",
       {"none.mcap", "zstd.mcap", "lz4.mcap", "unchunked.mcap", "unindexed.mcap"},
       "s.mcap"},
      {"SQLite3", {"rosbag2/rosbag2_0.db3"}, "s.db3"}};
  std::string folder = (fs::temp_directory_path() / "gw_fuzz_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return 1;
  for (const Reader& reader : readers) {
    std::vector<Content> contents;
    for (const char* name : reader.bags) contents.push_back(BytesOf(bags / name));
    Outcome outcome;
    while (outcome.bytes < bytes_per_reader) {
      CounterRng rng(42, outcome.files, static_cast<uint64_t>(reader.name[0]));
      const Content bytes = Spoilt(contents[outcome.files % contents.size()], rng);
      const fs::path file = fs::path(folder) / reader.spoilt_name;
      std::ofstream(file, std::ios::binary)
          .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
      ReadEverything(file);
      Import(file, outcome);
      outcome.bytes += bytes.size();
      ++outcome.files;
    }
    std::printf("%-8s %zu bytes in %zu spoilt files: %zu imported, %zu pairs of images read\n",
                reader.name, outcome.bytes, outcome.files, outcome.imported, outcome.images);
    // Spoiling that no file survives would test the first bytes alone.
    if (outcome.imported == 0) return 1;
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace gw::importer

int main(int argc, char** argv) {
  return argc == 2 ? gw::importer::Main(std::strtoull(argv[1], nullptr, 10)) : 2;
}

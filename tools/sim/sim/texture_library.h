// All textures of a simulated building, generated from a seed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/sim/sim/texture.h"

namespace gw::sim {

enum class Material {
  kPlaster,     // richly textured wall: rough plaster with stains
  kBrick,       // richly textured wall
  kPanelling,   // richly textured wall: wood with strong grain
  kFaint,       // painted wall: one to two grey levels of structure
  kBlank,       // no structure at all
  kRepetitive,  // the same small pattern over and over
  kWoodFloor,
  kCarpet,
  kLino,     // floor almost without structure
  kCeiling,  // tiles
  kPoster,   // print: headings, lines of text, photographs, charts
  kBooks,    // a filled shelf, seen from the front
  kCabinet,  // wooden front with doors and handles
  kCardboard,
  kDoor,
  kTrim,  // skirting boards, frames, table legs
  kLamp,
};
inline constexpr int kNumMaterials = 17;

class TextureLibrary {
 public:
  explicit TextureLibrary(uint64_t seed);

  const Texture& texture(int index) const { return textures_[index]; }
  // One of the variants of a material; `choice` is any number.
  int Variant(Material material, uint32_t choice) const {
    const Range& range = ranges_[static_cast<int>(material)];
    return range.first + static_cast<int>(choice % range.count);
  }
  // Side of one repetition of the texture in the world (m); 0: stretched over the whole surface.
  double PeriodMetres(Material material) const {
    return ranges_[static_cast<int>(material)].period_m;
  }

 private:
  struct Range {
    int first = 0;
    uint32_t count = 1;
    double period_m = 0;
  };
  std::vector<Texture> textures_;
  std::array<Range, kNumMaterials> ranges_;
};

}  // namespace gw::sim

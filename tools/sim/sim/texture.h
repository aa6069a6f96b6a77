// A mip-mapped grey texture that repeats in both directions.
#pragma once

#include <cstdint>
#include <vector>

namespace gw::sim {

class Texture {
 public:
  // width and height are powers of two; values are reflectances in [0, 1], row 0 first.
  Texture(int width, int height, const std::vector<float>& reflectance);

  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }
  int num_levels() const { return static_cast<int>(levels_.size()); }

  // Trilinear. u, v: texels of level 0, texel centres at integers; any finite value.
  // lod: >= 0, 0 is full resolution, each step halves it.
  float Sample(float u, float v, float lod) const {
    const int last = num_levels() - 1;
    int level = static_cast<int>(lod);
    if (level >= last) return Bilinear(levels_[last], u, v);
    const float fraction = lod - static_cast<float>(level);
    const float fine = Bilinear(levels_[level], u, v);
    if (fraction < 1.0f / 64) return fine;
    return fine + fraction * (Bilinear(levels_[level + 1], u, v) - fine);
  }
  // Bilinear in one level, or the last if there are fewer.
  float SampleLevel(float u, float v, int level) const {
    return Bilinear(levels_[level < num_levels() ? level : num_levels() - 1], u, v);
  }

 private:
  struct Level {
    int width = 0, height = 0;
    int shift = 0;    // log2(width)
    float scale = 1;  // texels of this level per texel of level 0
    std::vector<uint16_t> texels;
  };

  static float Bilinear(const Level& level, float u, float v) {
    // Centres of coarser texels lie between those of finer ones.
    const float x = (u + 0.5f) * level.scale - 0.5f;
    const float y = (v + 0.5f) * level.scale - 0.5f;
    const int ix = FloorToInt(x);
    const int iy = FloorToInt(y);
    const float fx = x - static_cast<float>(ix);
    const float fy = y - static_cast<float>(iy);
    const int x0 = ix & (level.width - 1);
    const int x1 = (ix + 1) & (level.width - 1);
    const uint16_t* row0 = level.texels.data() + ((iy & (level.height - 1)) << level.shift);
    const uint16_t* row1 = level.texels.data() + (((iy + 1) & (level.height - 1)) << level.shift);
    const float top = static_cast<float>(row0[x0]) +
                      fx * static_cast<float>(static_cast<int>(row0[x1]) - row0[x0]);
    const float bottom = static_cast<float>(row1[x0]) +
                         fx * static_cast<float>(static_cast<int>(row1[x1]) - row1[x0]);
    return (top + fy * (bottom - top)) * (1.0f / 65535.0f);
  }
  static int FloorToInt(float x) {
    const int i = static_cast<int>(x);
    return i - (x < static_cast<float>(i) ? 1 : 0);
  }

  std::vector<Level> levels_;
};

}  // namespace gw::sim

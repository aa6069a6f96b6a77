#include "tools/sim/sim/texture_library.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/core/random.h"

namespace gw::sim {
namespace {

// Texels of one texture while it is painted; coordinates wrap.
struct Canvas {
  int width, height;
  std::vector<float> values;

  Canvas(int w, int h, float value)
      : width(w), height(h), values(static_cast<size_t>(w) * h, value) {}
  float& at(int x, int y) {
    return values[static_cast<size_t>(y & (height - 1)) * width + (x & (width - 1))];
  }
  void Rect(int x0, int y0, int x1, int y1, float value) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) at(x, y) = value;
    }
  }
};

float Smooth(float t) {
  return t * t * (3 - 2 * t);
}

// Adds amplitude * value noise on a lattice of cells_x by cells_y, which wraps: the texture tiles.
void AddNoise(Canvas* canvas, CounterRng* rng, int cells_x, int cells_y, float amplitude) {
  std::vector<float> lattice(static_cast<size_t>(cells_x) * cells_y);
  for (float& value : lattice) value = static_cast<float>(rng->Uniform(-1, 1));
  for (int y = 0; y < canvas->height; ++y) {
    const float gy = (static_cast<float>(y) + 0.5f) * static_cast<float>(cells_y) /
                     static_cast<float>(canvas->height);
    const int iy = static_cast<int>(gy);
    const float fy = Smooth(gy - static_cast<float>(iy));
    const float* row0 = &lattice[static_cast<size_t>(iy % cells_y) * cells_x];
    const float* row1 = &lattice[static_cast<size_t>((iy + 1) % cells_y) * cells_x];
    for (int x = 0; x < canvas->width; ++x) {
      const float gx = (static_cast<float>(x) + 0.5f) * static_cast<float>(cells_x) /
                       static_cast<float>(canvas->width);
      const int ix = static_cast<int>(gx);
      const float fx = Smooth(gx - static_cast<float>(ix));
      const int x0 = ix % cells_x, x1 = (ix + 1) % cells_x;
      const float top = row0[x0] + fx * (row0[x1] - row0[x0]);
      const float bottom = row1[x0] + fx * (row1[x1] - row1[x0]);
      canvas->at(x, y) += amplitude * (top + fy * (bottom - top));
    }
  }
}

// 1/f noise: each octave half as large in size and `persistence` as strong.
void AddOneOverF(Canvas* canvas, CounterRng* rng, int first_cells, float amplitude,
                 float persistence) {
  for (int cells = first_cells; cells <= canvas->width / 2; cells *= 2) {
    AddNoise(canvas, rng, cells, std::max(1, cells * canvas->height / canvas->width), amplitude);
    amplitude *= persistence;
  }
}

// Chips, stains and scratches: what gives a corner detector something to hold on to.
void AddSpeckles(Canvas* canvas, CounterRng* rng, int count, int max_size, float contrast) {
  for (int i = 0; i < count; ++i) {
    const int x = static_cast<int>(rng->Below(canvas->width));
    const int y = static_cast<int>(rng->Below(canvas->height));
    const int w = 1 + static_cast<int>(rng->Below(max_size));
    const int h = 1 + static_cast<int>(rng->Below(max_size));
    const float change = contrast * static_cast<float>(rng->Uniform(-1, 1));
    for (int dy = 0; dy < h; ++dy) {
      for (int dx = 0; dx < w; ++dx) canvas->at(x + dx, y + dy) += change;
    }
  }
}

Canvas Plaster(CounterRng* rng) {
  Canvas c(512, 512, 0.55f + 0.1f * static_cast<float>(rng->Uniform(-1, 1)));
  AddOneOverF(&c, rng, 4, 0.11f, 0.85f);
  AddSpeckles(&c, rng, 2500, 4, 0.22f);
  return c;
}

Canvas Brick(CounterRng* rng) {
  Canvas c(512, 512, 0.62f);
  constexpr int kRows = 24, kColumns = 8, kMortar = 3;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int shift = row % 2 == 0 ? 0 : 32;
      const float value = 0.32f + 0.16f * static_cast<float>(rng->Uniform(-1, 1));
      const int top = row * 512 / kRows;
      c.Rect(column * 64 + shift, top, column * 64 + shift + 64 - kMortar,
             (row + 1) * 512 / kRows - kMortar, value);
    }
  }
  AddOneOverF(&c, rng, 16, 0.06f, 0.8f);
  AddSpeckles(&c, rng, 1500, 5, 0.2f);
  return c;
}

// Planks along y, `planks` of them side by side.
Canvas Wood(CounterRng* rng, int planks, float base, float contrast) {
  Canvas c(512, 512, base);
  AddNoise(&c, rng, 128, 4, contrast * 0.5f);  // grain: fine across, long along
  AddNoise(&c, rng, 256, 16, contrast * 0.5f);
  AddNoise(&c, rng, 32, 2, contrast * 0.6f);
  const int width = c.width / planks;
  for (int plank = 0; plank < planks; ++plank) {
    int y = static_cast<int>(rng->Below(c.height));
    const int joint_step = c.height / 2;
    for (int piece = 0; piece < 2; ++piece, y += joint_step) {
      const float change = contrast * static_cast<float>(rng->Uniform(-1, 1));
      for (int dy = 0; dy < joint_step; ++dy) {
        for (int dx = 0; dx < width; ++dx) c.at(plank * width + dx, y + dy) += change;
      }
      c.Rect(plank * width, y, plank * width + width, y + 2, base * 0.4f);
    }
    c.Rect(plank * width, 0, plank * width + 2, c.height, base * 0.45f);
    for (int knot = 0; knot < 3; ++knot) {
      const int kx = plank * width + 6 + static_cast<int>(rng->Below(std::max(1, width - 12)));
      const int ky = static_cast<int>(rng->Below(c.height));
      c.Rect(kx, ky, kx + 4, ky + 7, base * 0.5f);
    }
  }
  return c;
}

Canvas Carpet(CounterRng* rng) {
  Canvas c(512, 512, 0.3f);
  AddOneOverF(&c, rng, 8, 0.05f, 0.85f);
  AddNoise(&c, rng, 256, 256, 0.08f);
  AddSpeckles(&c, rng, 5000, 4, 0.25f);
  return c;
}

Canvas Faint(CounterRng* rng, float base, float amplitude) {
  Canvas c(512, 512, base);
  AddOneOverF(&c, rng, 8, amplitude, 0.8f);
  return c;
}

Canvas Repetitive(CounterRng* rng) {
  Canvas motif(64, 64, 0.62f);
  AddSpeckles(&motif, rng, 22, 14, 0.3f);
  Canvas c(512, 512, 0);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) c.at(x, y) = motif.at(x, y);
  }
  return c;
}

Canvas Ceiling(CounterRng* rng) {
  Canvas c(256, 256, 0.75f);
  AddOneOverF(&c, rng, 8, 0.01f, 0.9f);
  AddSpeckles(&c, rng, 700, 2, 0.10f);
  c.Rect(0, 0, 256, 3, 0.5f);
  c.Rect(0, 0, 3, 256, 0.5f);
  return c;
}

// A paragraph of print: words of dark strokes on a light ground.
void Text(Canvas* c, CounterRng* rng, int x0, int y0, int x1, int y1, int line, float ink) {
  for (int y = y0; y + line < y1; y += line + line / 2 + 1) {
    int x = x0;
    const int end = rng->Below(4) == 0 ? x0 + (x1 - x0) * 2 / 3 : x1;
    while (x < end) {
      const int word_end = std::min(end, x + line + static_cast<int>(rng->Below(5 * line)));
      for (; x < word_end; x += std::max(2, line / 2)) {  // one letter
        const int top = y + static_cast<int>(rng->Below(2)) * line / 3;
        const int stroke = std::max(1, line / 4);
        c->Rect(x, top, x + stroke, y + line, ink);
        if (rng->Below(2) == 0) c->Rect(x, top, x + line / 2, top + stroke, ink);
      }
      x += line;
    }
  }
}

void Photograph(Canvas* c, CounterRng* rng, int x0, int y0, int x1, int y1) {
  Canvas photo(256, 256, 0.45f);
  AddOneOverF(&photo, rng, 2, 0.3f, 0.7f);
  for (int i = 0; i < 8; ++i) {  // figures with clear outlines
    const int cx = static_cast<int>(rng->Below(256)), cy = static_cast<int>(rng->Below(256));
    const int radius = 8 + static_cast<int>(rng->Below(30));
    const float value = static_cast<float>(rng->Uniform(0.05, 0.9));
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) {
        if (x * x + y * y <= radius * radius) photo.at(cx + x, cy + y) = value;
      }
    }
  }
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) c->at(x, y) = std::clamp(photo.at(x, y), 0.03f, 0.9f);
  }
}

void Chart(Canvas* c, CounterRng* rng, int x0, int y0, int x1, int y1) {
  c->Rect(x0, y0, x0 + 2, y1, 0.1f);
  c->Rect(x0, y1 - 2, x1, y1, 0.1f);
  const int bars = 5 + static_cast<int>(rng->Below(6));
  for (int bar = 0; bar < bars; ++bar) {
    const int bx = x0 + 5 + bar * (x1 - x0 - 5) / bars;
    const int top = y0 + static_cast<int>(rng->Below(std::max(1, y1 - y0 - 6)));
    c->Rect(bx, top, bx + (x1 - x0) / bars - 3, y1 - 2, static_cast<float>(rng->Uniform(0.1, 0.7)));
  }
}

Canvas Poster(CounterRng* rng) {
  const bool dark = rng->Below(4) == 0;
  const float paper = dark ? 0.2f : 0.86f;
  const float ink = dark ? 0.85f : 0.08f;
  Canvas c(256, 256, paper);
  Text(&c, rng, 14, 12, 242, 46, 20, ink);
  const uint32_t layout = rng->Below(4);
  if (layout == 0) {
    Photograph(&c, rng, 14, 52, 242, 170);
    Text(&c, rng, 14, 178, 242, 248, 6, ink);
  } else if (layout == 1) {
    Text(&c, rng, 14, 52, 122, 246, 6, ink);
    Photograph(&c, rng, 132, 52, 242, 140);
    Chart(&c, rng, 132, 150, 242, 244);
  } else if (layout == 2) {
    Chart(&c, rng, 14, 54, 122, 140);
    Chart(&c, rng, 132, 54, 242, 140);
    Text(&c, rng, 14, 150, 242, 246, 8, ink);
  } else {
    Photograph(&c, rng, 6, 50, 250, 250);
    Text(&c, rng, 20, 200, 200, 240, 14, 0.9f);
  }
  c.Rect(0, 0, 256, 3, 0.15f);  // frame
  c.Rect(0, 253, 256, 256, 0.15f);
  c.Rect(0, 0, 3, 256, 0.15f);
  c.Rect(253, 0, 256, 256, 0.15f);
  return c;
}

Canvas Books(CounterRng* rng) {
  Canvas c(256, 512, 0.06f);
  constexpr int kShelves = 6;
  for (int shelf = 0; shelf < kShelves; ++shelf) {
    const int bottom = (shelf + 1) * 512 / kShelves - 6;
    const int room = 512 / kShelves - 14;
    for (int x = 5; x < 246;) {
      if (rng->Below(12) == 0) {  // gap
        x += 6 + static_cast<int>(rng->Below(22));
        continue;
      }
      const int w = std::min(250 - x, 4 + static_cast<int>(rng->Below(11)));
      const int h = room * (60 + static_cast<int>(rng->Below(38))) / 100;
      const float value = static_cast<float>(rng->Uniform(0.08, 0.8));
      c.Rect(x, bottom - h, x + w, bottom, value);
      c.Rect(x, bottom - h, x + 1, bottom, 0.05f);
      const float label = value > 0.4f ? 0.1f : 0.8f;
      if (w > 6) Text(&c, rng, x + 2, bottom - h + 6, x + w - 1, bottom - h / 2, 4, label);
      if (rng->Below(2) == 0) c.Rect(x + 1, bottom - 12, x + w - 1, bottom - 8, label);
      x += w;
    }
    c.Rect(0, bottom, 256, bottom + 6, 0.4f);
  }
  c.Rect(0, 0, 5, 512, 0.4f);
  c.Rect(251, 0, 256, 512, 0.4f);
  c.Rect(0, 0, 256, 6, 0.4f);
  return c;
}

Canvas Cabinet(CounterRng* rng) {
  Canvas c = Wood(rng, 1, 0.45f, 0.08f);
  for (int column = 0; column < 2; ++column) {
    for (int row = 0; row < 3; ++row) {
      const int x = column * 256, y = row * 170;
      c.Rect(x, y, x + 256, y + 3, 0.12f);
      c.Rect(x, y, x + 3, y + 170, 0.12f);
      c.Rect(x + 108, y + 22, x + 148, y + 30, 0.75f);
      c.Rect(x + 108, y + 30, x + 148, y + 33, 0.1f);
      if (rng->Below(2) == 0) {
        c.Rect(x + 90, y + 60, x + 166, y + 100, 0.85f);
        Text(&c, rng, x + 96, y + 64, x + 162, y + 98, 7, 0.1f);
      }
    }
  }
  return c;
}

Canvas Cardboard(CounterRng* rng) {
  Canvas c(256, 256, 0.42f);
  AddOneOverF(&c, rng, 4, 0.03f, 0.8f);
  c.Rect(0, 120, 256, 136, 0.56f);  // tape
  Text(&c, rng, 20, 20, 150, 70, 12, 0.1f);
  c.Rect(170, 20, 240, 90, 0.1f);
  c.Rect(176, 26, 234, 84, 0.6f);
  Text(&c, rng, 180, 30, 232, 82, 8, 0.1f);
  Text(&c, rng, 20, 160, 230, 240, 6, 0.15f);
  return c;
}

Canvas Door(CounterRng* rng) {
  Canvas c(256, 512, 0.5f);
  AddNoise(&c, rng, 64, 2, 0.03f);
  AddNoise(&c, rng, 128, 8, 0.02f);
  const float groove = 0.3f;
  for (const int y : {40, 280}) {
    c.Rect(40, y, 216, y + 4, groove);
    c.Rect(40, y + 190, 216, y + 194, groove);
    c.Rect(40, y, 44, y + 190, groove);
    c.Rect(212, y, 216, y + 190, groove);
  }
  c.Rect(222, 260, 240, 268, 0.85f);  // handle
  c.Rect(226, 250, 234, 290, 0.7f);
  c.Rect(80, 90, 176, 130, 0.88f);  // sign
  Text(&c, rng, 86, 94, 172, 128, 11, 0.08f);
  c.Rect(0, 490, 256, 512, 0.6f);  // kick plate
  return c;
}

Canvas Lamp() {
  Canvas c(64, 64, 1.0f);
  for (const int at : {0, 16, 32, 48}) {
    c.Rect(at, 0, at + 1, 64, 0.8f);
    c.Rect(0, at, 64, at + 1, 0.8f);
  }
  return c;
}

}  // namespace

TextureLibrary::TextureLibrary(uint64_t seed) {
  const auto add = [&](Material material, uint32_t count, double period_m,
                       const std::function<Canvas(CounterRng*)>& paint) {
    ranges_[static_cast<int>(material)] = {static_cast<int>(textures_.size()), count, period_m};
    for (uint32_t variant = 0; variant < count; ++variant) {
      CounterRng rng(seed, 0x7E87 + static_cast<uint64_t>(material), variant);
      const Canvas canvas = paint(&rng);
      textures_.emplace_back(canvas.width, canvas.height, canvas.values);
    }
  };
  add(Material::kPlaster, 4, 3.0, Plaster);
  add(Material::kBrick, 2, 2.0, Brick);
  add(Material::kPanelling, 2, 2.4, [](CounterRng* r) { return Wood(r, 8, 0.4f, 0.13f); });
  // Amplitudes are of the largest octave; a wall of reflectance 0.7 is about 110 grey levels.
  add(Material::kFaint, 2, 2.5, [](CounterRng* r) { return Faint(r, 0.7f, 0.004f); });
  add(Material::kBlank, 1, 1.0, [](CounterRng* r) { return Faint(r, 0.7f, 0); });
  add(Material::kRepetitive, 2, 2.0, Repetitive);
  add(Material::kWoodFloor, 2, 1.6, [](CounterRng* r) { return Wood(r, 12, 0.36f, 0.12f); });
  add(Material::kCarpet, 2, 1.5, Carpet);
  add(Material::kLino, 1, 2.0, [](CounterRng* r) { return Faint(r, 0.4f, 0.004f); });
  add(Material::kCeiling, 1, 0.6, Ceiling);
  add(Material::kPoster, 32, 0, Poster);
  add(Material::kBooks, 6, 0, Books);
  add(Material::kCabinet, 3, 0, Cabinet);
  add(Material::kCardboard, 3, 0, Cardboard);
  add(Material::kDoor, 4, 0, Door);
  add(Material::kTrim, 1, 1.0, [](CounterRng* r) { return Faint(r, 0.3f, 0.01f); });
  add(Material::kLamp, 1, 0, [](CounterRng*) { return Lamp(); });
}

}  // namespace gw::sim

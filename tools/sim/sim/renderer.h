// Renders a World through an ideal pinhole camera: radiance and inverse depth of every pixel.
//
// Two steps. First the surfaces are drawn without texture into a buffer of 2 x 2 samples a pixel
// that holds inverse depth and surface. Then every pixel is textured and lit once, or once for each
// surface that its samples show: outlines are smooth, and cost grows with pixels and outlines, not
// with how many walls stand behind each other. Texturing is trilinear with up to 4 samples along
// the longer axis of the pixel's footprint, which a floor seen from a robot needs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/core/se3.h"
#include "tools/sim/sim/parallel.h"
#include "tools/sim/sim/world.h"

namespace gw::sim {

struct Pinhole {
  int width = 640, height = 480;                  // px
  double fx = 385, fy = 385, cx = 320, cy = 240;  // px; pixel (0, 0) is the centre of the first one
};

struct RenderedImage {
  int width = 0, height = 0;
  std::vector<float> radiance;  // 1: a white wall in the light that the exposure is made for
  std::vector<float>
      inverse_depth;  // 1/m along the optical axis, at the pixel's centre; 0: nothing
};

class Renderer {
 public:
  // `world` and `pool` must outlive the renderer.
  Renderer(const World& world, const Pinhole& camera, WorkerPool* pool);

  // T_WC: optical frame (x right, y down, z forward) in the world. light: of all lamps, 1 = on,
  // 0 = dark. The result depends on the arguments alone.
  void Render(const SE3& T_WC, double light, RenderedImage* out);

 private:
  struct Vertex {
    float x, y, w;  // sub-sample coordinates and inverse depth
  };
  // A surface in front of the camera. Quantities are linear in the pixel: q(x, y) = q[0] + q[1] x +
  // q[2] y. w is the inverse depth; u and v are texels times w.
  struct Gradients {
    float w_x, w_y, u_x, u_y, v_x, v_y;
  };
  struct Visible {
    int num_vertices = 0;
    Vertex vertices[8];
    float y_min = 0, y_max = 0;  // sub-sample rows
    double w[3], u[3], v[3];
    Gradients gradients;
    const Texture* texture;
    float u_offset, v_offset, emission;
    const float* light;  // baked, light_width samples a row
    int light_width;
    float light_per_u, light_per_v, light_x_max, light_y_max;
  };
  struct Band {  // scratch memory of one thread
    std::vector<float> w;
    std::vector<int32_t> id;
  };

  void Project(const SE3& T_WC);
  void RenderBand(int band, Band* scratch, double light, RenderedImage* out) const;
  void Fill(const Visible& visible, int32_t id, int first_row, int rows, Band* scratch) const;
  float Shade(const Visible& visible, double x, double y) const;

  const World& world_;
  Pinhole camera_;
  WorkerPool* pool_;
  std::vector<Visible> visible_;
  std::vector<Band> scratch_;
};

}  // namespace gw::sim

// How a configuration struct declares its fields: once, in its own VisitFields(visitor). Loader,
// checker, documentation and schema all walk this one list. A visitor provides
//
//   void Field(const char* name, T& value, FieldSpec spec)    T: bool, int, double, std::string,
//   std::array<double, N> void Enum(const char* name, E& value, EnumChoices<E> choices, FieldSpec
//   spec) void Pose(const char* name, SE3& value, FieldSpec spec)   YAML: {p: [x, y, z], q_wxyz:
//   [w, x, y, z]}, metres void Section(const char* name, S& section, FieldSpec spec)  S has
//   VisitFields
//
// No YAML here: the cores see configuration only as plain structs.
#pragma once

#include <limits>
#include <utility>
#include <vector>

namespace gw {

struct FieldSpec {
  double min = -std::numeric_limits<double>::infinity();  // numbers: smallest legal value
  double max = std::numeric_limits<double>::infinity();   // numbers: largest legal value
  const char* unit = "";                                  // of the value, for the reference page
  bool required = false;  // no default: a file without it is refused
  const char* text = "";  // what it does, for the reference page
};

template <typename E>
using EnumChoices = std::vector<std::pair<const char*, E>>;

}  // namespace gw

// Tests: our encoding beside the code that lcm-gen makes from the same .lcm files.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/wire/wire.h"

namespace gw::wire {

// What lcm-gen's own code makes of our bytes; it must take all of them.
template <typename Type>
Type Generated(const Bytes& bytes) {
  Type generated;
  EXPECT_EQ(generated.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return generated;
}

template <typename Type>
Bytes GeneratedBytes(const Type& generated) {
  Bytes bytes(generated.getEncodedSize());
  EXPECT_EQ(generated.encode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  return bytes;
}

// `broken` is valid but for one field: that is refused, by name.
template <typename Contract, typename Type>
void ExpectRefused(const Type& broken, const std::string& field) {
  const auto decoded = Decode<Contract>(GeneratedBytes(broken));
  ASSERT_FALSE(decoded.ok()) << field;
  EXPECT_EQ(decoded.error().code, ErrorCode::kBadData);
  EXPECT_THAT(decoded.error().message, ::testing::HasSubstr(": " + field + " is "));
}

}  // namespace gw::wire

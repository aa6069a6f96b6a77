#include "drivers/kobuki/device/find_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace gw::kobuki {
namespace {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;

// A /dev and a /sys of our own.
class FindPortTest : public testing::Test {
 protected:
  FindPortTest()
      : root_(fs::path(testing::TempDir()) / ("find_port_" + std::to_string(::getpid()))) {
    fs::create_directories(root_ / "dev");
    fs::create_directories(root_ / "class");
    roots_ = {(root_ / "dev").string(), (root_ / "class").string()};
  }
  ~FindPortTest() override { fs::remove_all(root_); }

  // Lays the folders out as the kernel does: class/ttyUSB0/device -> usb/1-2/1-2:1.0/ttyUSB0.
  void AddAdapter(const std::string& port, const std::string& serial) {
    const fs::path usb = root_ / "usb" / port;
    fs::create_directories(usb / "if0" / port);
    fs::create_directories(root_ / "class" / port);
    std::ofstream(usb / "idVendor") << "0403\n";
    std::ofstream(usb / "serial") << serial << "\n";
    fs::create_directory_symlink(usb / "if0" / port, root_ / "class" / port / "device");
  }

  fs::path root_;
  SystemRoots roots_;
};

TEST_F(FindPortTest, PathIsTakenAsItIs) {
  EXPECT_EQ(*FindPort("/dev/ttyUSB7", roots_), "/dev/ttyUSB7");
}

TEST_F(FindPortTest, AutoTakesTheSymlinkElseTheOnlyKobuki) {
  AddAdapter("ttyUSB0", "FT123456");
  AddAdapter("ttyUSB1", "kobuki_A505QO28");
  EXPECT_THAT(*FindPort("auto", roots_), EndsWith("/dev/ttyUSB1"));
  std::ofstream(root_ / "dev" / "kobuki") << "";
  EXPECT_THAT(*FindPort("auto", roots_), EndsWith("/dev/kobuki"));
}

TEST_F(FindPortTest, SerialNumberFindsThePortWhereverItIs) {
  AddAdapter("ttyUSB0", "kobuki_A");
  AddAdapter("ttyUSB5", "kobuki_B");
  EXPECT_THAT(*FindPort("kobuki_B", roots_), EndsWith("/dev/ttyUSB5"));
  const auto none = FindPort("kobuki_C", roots_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(none.error().message, HasSubstr("kobuki_A, kobuki_B"));
}

TEST_F(FindPortTest, SeveralBasesAndNoneAreRefusedWithAdvice) {
  EXPECT_THAT(FindPort("auto", roots_).error().message, HasSubstr("no USB serial adapter"));
  AddAdapter("ttyUSB0", "kobuki_A");
  AddAdapter("ttyUSB1", "kobuki_B");
  EXPECT_EQ(FindPort("auto", roots_).error().code, ErrorCode::kBadConfig);
  EXPECT_EQ(FindPort("auto", {"/nowhere", "/nowhere"}).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace gw::kobuki

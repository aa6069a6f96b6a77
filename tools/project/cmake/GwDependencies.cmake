# Every third-party package, once. A package is linked only through the target named here;
# docs/adr/0001-layers.md says which of our targets may see which.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc calib3d features2d imgcodecs video)
find_package(Ceres 2.1 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)

# Debian's LCM has no CMake package, and lcm.pc asks for GLib headers that we do not need.
find_path(GW_LCM_INCLUDE lcm/lcm-cpp.hpp REQUIRED)
find_library(GW_LCM_LIBRARY lcm REQUIRED)
find_program(GW_LCM_GEN lcm-gen REQUIRED)
add_library(gw_lcm INTERFACE)
target_include_directories(gw_lcm SYSTEM INTERFACE ${GW_LCM_INCLUDE})
target_link_libraries(gw_lcm INTERFACE ${GW_LCM_LIBRARY})

# OpenCV's imported targets, as system headers and only the modules we use.
add_library(gw_opencv INTERFACE)
target_include_directories(gw_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(gw_opencv INTERFACE opencv_core opencv_imgproc opencv_features2d opencv_imgcodecs)

# Debian's libusb has no CMake package.
find_path(GW_LIBUSB_INCLUDE libusb-1.0/libusb.h REQUIRED)
find_library(GW_LIBUSB_LIBRARY usb-1.0 REQUIRED)
add_library(gw_libusb INTERFACE)
target_include_directories(gw_libusb SYSTEM INTERFACE ${GW_LIBUSB_INCLUDE})
target_link_libraries(gw_libusb INTERFACE ${GW_LIBUSB_LIBRARY})

# Compressions and the database of ROS bags. Debian's packages have no CMake configuration.
add_library(gw_compression INTERFACE)
foreach(part bzlib.h:bz2 lz4frame.h:lz4 zstd.h:zstd)
  string(REPLACE ":" ";" part ${part})
  list(GET part 0 header)
  list(GET part 1 library)
  find_path(GW_${library}_INCLUDE ${header} REQUIRED)
  find_library(GW_${library}_LIBRARY ${library} REQUIRED)
  target_include_directories(gw_compression SYSTEM INTERFACE ${GW_${library}_INCLUDE})
  target_link_libraries(gw_compression INTERFACE ${GW_${library}_LIBRARY})
endforeach()
find_package(SQLite3 REQUIRED)
add_library(gw_sqlite INTERFACE)
target_link_libraries(gw_sqlite INTERFACE SQLite::SQLite3)

# Boost's Beast and Asio, headers only.
find_path(GW_BEAST_INCLUDE boost/beast/websocket.hpp REQUIRED)
add_library(gw_beast INTERFACE)
target_include_directories(gw_beast SYSTEM INTERFACE ${GW_BEAST_INCLUDE})
target_link_libraries(gw_beast INTERFACE Threads::Threads)

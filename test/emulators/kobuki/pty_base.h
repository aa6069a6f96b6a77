// The emulated base behind a pseudo terminal, in real time: a driver opens it as a serial port.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/core/result.h"
#include "common/process/file_handle.h"
#include "test/emulators/kobuki/emulator.h"

namespace gw::kobuki {

class PtyBase {
 public:
  // `link` is the path of a symbolic link to the terminal, as udev makes one; it is replaced if it
  // is there, and removed on unplugging. Error kIo: no terminal or no link can be made.
  static Result<std::unique_ptr<PtyBase>> Create(const EmulatorConfig& config,
                                                 const std::string& link);
  ~PtyBase();

  // Pulls the cable out, or puts it in again: the terminal vanishes, and comes back as another one
  // behind the same link.
  void Unplug();
  Result<Done> Plug();

  // Works on the emulator between two of its steps.
  void With(const std::function<void(Emulator&)>& work);
  // Sends these bytes instead of feedback from now on; feedback again when they are empty.
  void SendGarbage(std::vector<uint8_t> bytes);

 private:
  PtyBase(const EmulatorConfig& config, std::string link);
  void Run();

  std::string link_;
  std::mutex mutex_;  // guards everything below
  process::FileHandle master_;
  // The other end, which is kept open so that the terminal does not hang up while no driver has it.
  process::FileHandle slave_;
  Emulator emulator_;
  std::vector<uint8_t> garbage_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace gw::kobuki

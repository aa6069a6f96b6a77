// Words of a command line for the shell, whatever is in them.
#pragma once

#include <string>

namespace gw::tools {

// In quotes where it must be.
std::string ShellWord(const std::string& word);

}  // namespace gw::tools

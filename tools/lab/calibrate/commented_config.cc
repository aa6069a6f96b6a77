#include "tools/lab/calibrate/commented_config.h"

#include <sstream>

#include "common/config/writer.h"
#include "tools/data/files/text_file.h"

namespace gw::calibrate {

Result<Done> WriteCommented(const std::string& file, const std::string& made_by,
                            const std::string& report, const RobotConfig& config) {
  std::string text = "# Written by " + made_by + ", which found:\n";
  std::istringstream lines(report);
  for (std::string line; std::getline(lines, line);) text += "#   " + line + "\n";
  return tools::WriteTextFile(file, text + WriteRobotConfig(config, ConfigText::kShort));
}

}  // namespace gw::calibrate

// The table of studies: one line per subcommand of gw-study, one file per study.
#pragma once

#include <memory>

#include "common/cli/command.h"
#include "tools/lab/study/experiment.h"

namespace gw::study {

class Study {
 public:
  virtual ~Study() = default;
  // The study's own arguments; --out is there already.
  virtual void AddOptions(cli::Command& app) = 0;
  // After parsing. Progress goes to stderr.
  virtual Result<StudyFiles> Run() = 0;
};

std::unique_ptr<Study> MakeQualityStudy();
std::unique_ptr<Study> MakeAlphaSweepStudy();
std::unique_ptr<Study> MakeLatencyStudy();
std::unique_ptr<Study> MakeRepeatRunStudy();
std::unique_ptr<Study> MakeLocalizeStudy();
std::unique_ptr<Study> MakeLoopsStudy();
std::unique_ptr<Study> MakeClosedLoopStudy();
std::unique_ptr<Study> MakeDrFaultsStudy();
std::unique_ptr<Study> MakeVisionFaultsStudy();
std::unique_ptr<Study> MakeRealWheelsStudy();

}  // namespace gw::study
